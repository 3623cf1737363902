// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "builder/planes/keyframe_sample.h"
#include "core/base/options.h"
#include "core/features/features.h"
#include "localizer/localizer.h"
#include "localizer/verdict/verdict_model.h"
#include "schema/map_data.h"

namespace waystone {

// How the verdict of planes is calibrated.
struct CalibrationOptions {
  int max_keyframes = 40;
  int rendered_negatives = 8;
  LocalizeOptions localize;
  FitOptions fit;
  uint64_t seed = 1;

  static constexpr auto Fields(const auto& use) {
    return use(OptionField{"max_keyframes", &CalibrationOptions::max_keyframes, AtLeast(2), "",
                           "Number of keyframes with which the finished map is queried. More "
                           "keyframes fit the model better, at about 30 ms each."},
               OptionField{"rendered_negatives", &CalibrationOptions::rendered_negatives,
                           Closed(0, 100'000), "",
                           "Number of additional query images of a rendered building, which is not "
                           "in the map; about 100 ms each."},
               OptionGroup{"localize", &CalibrationOptions::localize},
               OptionGroup{"fit", &CalibrationOptions::fit},
               OptionField{"seed", &CalibrationOptions::seed, AnyValue(), "",
                           "Random seed of the scrambled negatives."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// The model of the verdict, fitted to answers of the map itself. Each keyframe is queried without
// the features whose exact descriptors the map has, which it took from that image (leave one out):
// the place that it shows is a right one. Features that were described anew, such as those of
// stored pictures (RecalibratePlaneLayer), differ from the map's and are all used. The best plane
// for the same features with their positions exchanged is a wrong one: its matches look alike, but
// fit only by chance; so is the best plane for each of `outside`, pictures of what the map doesn't
// show (RenderNegatives). Fitting places elsewhere aren't used as wrong ones: often they are the
// same surface, seen another time, and otherwise the answer is `ambiguous`. Deterministic on any
// number of threads.
VerdictModel CalibrateVerdict(const MapIndex& index, const std::vector<SampledKeyframe>& queries,
                              const std::vector<Features>& outside,
                              const CalibrationOptions& options);

// Fits the model of the map's planes to `samples` and to rendered negatives (MapData::verdict).
// Copies the keyframes without their pictures, and nothing of the other layers.
void CalibratePlaneLayer(MapData& map, const std::vector<SampledKeyframe>& samples,
                         const FeatureOptions& features, const CalibrationOptions& options);

}  // namespace waystone
