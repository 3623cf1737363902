// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "builder/appearance/options.h"
#include "builder/calibration/appearance_calibration.h"
#include "builder/calibration/plane_calibration.h"
#include "builder/layer_choice.h"
#include "builder/orientation/options.h"
#include "builder/planes/keyframe_selector.h"
#include "builder/planes/options.h"
#include "builder/poses/options.h"
#include "core/base/options.h"
#include "core/features/features.h"

namespace waystone {

struct BuildOptions {
  std::string map_name = "map";
  // Half of the pixels of a camera of 640x480: more find no more places and take longer
  // (docs/benchmarks.md, Working size).
  FeatureOptions features{.working_pixels = 640 * 480 / 2};
  KeyframeOptions keyframes;
  PlaneLayerOptions planes;
  AppearanceOptions appearance;
  OrientationOptions orientation;
  LayerChoice layers;
  CalibrationOptions calibration;
  AppearanceCalibrationOptions appearance_calibration;
  double max_skipped_share = 0.5;
  bool images = true;
  int image_width = 320;
  // Threads for reading and features; 0 uses all cores. The map doesn't depend on it.
  int threads = 0;

  // Only used with poses; maps don't record it.
  PoseOptions poses = {};

  // The map's name, which is stored elsewhere, the threads, on which no map depends, and the poses'
  // options.
  static constexpr int kUnlistedMembers = 3;
  static constexpr auto Fields(const auto& use) {
    return use(
        OptionGroup{"features", &BuildOptions::features},
        OptionGroup{"keyframes", &BuildOptions::keyframes},
        OptionGroup{"planes", &BuildOptions::planes},
        OptionGroup{"appearance", &BuildOptions::appearance},
        OptionGroup{"orientation", &BuildOptions::orientation},
        OptionGroup{"layers", &BuildOptions::layers},
        OptionGroup{"calibration", &BuildOptions::calibration},
        OptionGroup{"appearance_calibration", &BuildOptions::appearance_calibration},
        OptionField{"max_skipped_share", &BuildOptions::max_skipped_share, Closed(0, 1), "",
                    "Maximum share of a sequence's frames that a layer may be unable to use. Above "
                    "it, the build fails, since the map would have unexpected gaps."},
        OptionField{
            "images", &BuildOptions::images, AnyValue(), "",
            "Whether to store a smaller image of each keyframe and node in the map, for display."},
        OptionField{
            "image_width", &BuildOptions::image_width, Closed(16, 4096), "px",
            "Width of those images. Larger images show more, and make up most of a map's size."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

}  // namespace waystone
