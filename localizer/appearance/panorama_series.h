// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "core/geometry/pose2.h"
#include "core/localization/graph_filter.h"
#include "localizer/appearance/appearance.h"

namespace waystone {

// What is known about a robot when the next panorama of its series arrives.
struct SeriesContext {
  FilterState previous;  // Answer::belief of the panorama before; empty for the first
  // The motion since then, previous_from_now in the layer's units, where it is known.
  std::optional<Pose2> odometry;
  // Answer::described of the panorama before, where the client still has it: without odometry, it
  // shows whether the robot stands still.
  std::optional<FourierSignature> described = {};
};

struct SeriesOptions {
  PanoramaQueryOptions query;
  // The probability that the robot was carried elsewhere between two images, and how many beliefs a
  // state keeps; its lengths are overridden by those below.
  GraphFilterOptions filter;
  double position_spacings = 1;
  double step_spacings = 3;
  double max_log_odds = 4;
  double min_alone = 0.5;

  static constexpr auto Fields(const auto& use) {
    using Self = SeriesOptions;
    return use(
        OptionGroup{"query", &Self::query},
        OptionField{"position_spacings", &Self::position_spacings, Closed(0.01, 1000), "",
                    "The filter's position_sigma, in spacings of the map's nodes. Higher values "
                    "let neighbours share the belief."},
        OptionField{"step_spacings", &Self::step_spacings, Closed(0.01, 1000), "",
                    "The filter's step_sigma without odometry, in spacings of the map's nodes. "
                    "Higher values let the robot move farther between two images."},
        OptionField{"max_log_odds", &Self::max_log_odds, Closed(0.1, 100), "",
                    "Maximum contribution of one image to a node's log odds, since consecutive "
                    "images are not independent evidence. Lower values take longer to decide."},
        OptionField{"min_alone", &Self::min_alone, Closed(0, 1), "",
                    "A panorama counts if its most probable place would have at least this "
                    "probability if no other place resembled it. Lower values let panoramas of "
                    "places that aren't in the map change the belief."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// The belief about where the robot is, after a panorama that was compared with these nodes
// (CompareQuery), from what was known before. Empty context: a robot that may be anywhere. Images
// of one place aren't independent evidence: one that supports the current belief counts by the
// distance that the robot has moved over the map's spacing, at most 1.
// Thread-safe, deterministic. Throws MapError(kBadRequest) for a belief of another map.
FilterState BeliefAfter(const MapIndex& index, const std::vector<ComparedNode>& compared,
                        bool verified, const SeriesContext& context, const SeriesOptions& options);

// The next panorama of a series: what it looks like (CompareQuery) and where the robot was before
// (UpdateBelief), so that similar places are distinguished as it moves. The belief chooses the
// place; the position and the nearest node within it are what the panorama shows (TakePlace), or
// the belief's mean where the panorama doesn't support that place by itself. The probability is the
// belief's around the answer, and the deciding gate kSeries; Answer::belief is the input for the
// next one. A panorama that looks like no place of the map is answered "not in the map" and leaves
// the belief as it was. Thread-safe, deterministic. Throws MapError(kBadOptions), and kBadRequest
// for a belief of another map.
Answer ContinueSeries(const MapIndex& index, const PanoramaQuery& query,
                      const SeriesContext& context, const SeriesOptions& options = {});

// The same for an image, with times; nothing is thrown for a bad panorama: the verdict is
// kBadImage, and the belief stays as it was. Thread-safe.
Answer LocalizeInSeries(const MapIndex& index, const cv::Mat& grey, const SeriesContext& context,
                        const SeriesOptions& options = {});

}  // namespace waystone
