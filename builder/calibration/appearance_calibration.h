// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "builder/appearance/appearance_layer.h"
#include "builder/calibration/own_images.h"
#include "core/base/options.h"
#include "localizer/appearance/appearance.h"

namespace waystone {

// How the verdict of panoramas is calibrated.
struct AppearanceCalibrationOptions {
  int max_nodes = 60;
  double right_spacings = 2;
  std::vector<double> blank_spacings = {0, 4, 6};
  double min_right_share = 0.95;
  int rendered_negatives = 12;
  PanoramaQueryOptions query;
  AppearanceFitOptions fit;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"max_nodes", &AppearanceCalibrationOptions::max_nodes, Closed(1, 100'000), "",
                    "Number of panoramas with which the finished layer is queried, spread evenly "
                    "over it. More panoramas fit the model better; each costs one query per value "
                    "of blank_spacings."},
        OptionField{"right_spacings", &AppearanceCalibrationOptions::right_spacings,
                    Closed(0.1, 100), "node spacings",
                    "An answer within this distance of the truth is right."},
        OptionField{"blank_spacings", &AppearanceCalibrationOptions::blank_spacings,
                    Closed(0, 1000), "node spacings",
                    "Each panorama is queried as if its surroundings were not in the map, that is, "
                    "without the nodes within this many spacings; 0 leaves out only the panorama "
                    "itself. Beyond query.elsewhere_spacings, answers are only slightly wrong, and "
                    "the model learns to refuse them."},
        OptionField{"min_right_share", &AppearanceCalibrationOptions::min_right_share, Closed(0, 1),
                    "",
                    "Minimum share of the answers that the default model is sure of that must be "
                    "right according to the map's poses. Below it, the trajectory is too "
                    "inaccurate to learn from, and the default model is used.",
                    OptionUse::kInternal},
        OptionField{"rendered_negatives", &AppearanceCalibrationOptions::rendered_negatives,
                    Closed(0, 1000), "",
                    "Number of additional query panoramas of a rendered building, which is not in "
                    "the map; about 50 ms each."},
        OptionGroup{"query", &AppearanceCalibrationOptions::query},
        OptionGroup{"fit", &AppearanceCalibrationOptions::fit});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// A panorama whose true pose is known.
struct AppearanceCalibrationQuery {
  PanoramaQuery query;
  Pose2 truth;      // in the layer's frame
  int node = -1;    // its node in the layer; -1 where it was left out as redundant
  int beside = -1;  // a node on its floor: itself, or the nearest of its sequence; -1: unknown
};

// The model for one kind of answers (verified by features, or by appearance only), fitted to
// answers of the map itself: each query is localized without the nodes within the options' radii
// around it, and the answer is right or wrong by its distance (in poses or edges). The default
// model where sure answers contradict the map's poses. `outside` are panoramas of places that the
// map doesn't show. Samples of the other kind are left out. `before_each`, where given, is called
// before each query, from any thread and by several at a time; what it throws ends the fit. Throws
// MapError(kBadOptions); the map has an appearance layer (WS_CHECK). Deterministic on any number of
// threads.
AppearanceVerdict CalibrateAppearance(const MapIndex& index,
                                      const std::vector<AppearanceCalibrationQuery>& queries,
                                      const std::vector<PanoramaQuery>& outside, bool verified,
                                      const AppearanceCalibrationOptions& options = {},
                                      const std::function<void()>& before_each = {});

// Fits the models of the map's appearance layer, for answers by appearance only and, where the
// nodes keep features, for verified ones, to `samples` and to rendered negatives. Returns how many
// of the samples the map recognises; models that lose more than 1 % of them are replaced by the
// default ones. Reports the stage "calibration".
OwnImages CalibrateAppearanceLayer(MapData& map, const std::vector<AppearanceSampleFrame>& samples,
                                   const AppearanceCalibrationOptions& options,
                                   ProgressReporter& progress);

}  // namespace waystone
