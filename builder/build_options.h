// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <tuple>

#include "builder/appearance/options.h"
#include "builder/calibration/appearance_calibration.h"
#include "builder/calibration/plane_calibration.h"
#include "builder/layer_choice.h"
#include "builder/orientation/options.h"
#include "builder/planes/keyframe_selector.h"
#include "builder/planes/options.h"
#include "core/base/options.h"
#include "core/features/features.h"

namespace waystone {

// Everything a map is built with.
struct BuildOptions {
  std::string map_name = "map";
  FeatureOptions features;
  KeyframeOptions keyframes;
  PlaneLayerOptions planes;
  AppearanceOptions appearance;
  OrientationOptions orientation;
  LayerChoice layers;
  CalibrationOptions calibration;
  AppearanceCalibrationOptions appearance_calibration;
  bool images = true;
  int image_width = 320;
  int threads = 0;

  static constexpr auto Fields() {
    return std::tuple{
        OptionGroup{"keyframes", &BuildOptions::keyframes},
        OptionGroup{"planes", &BuildOptions::planes},
        OptionGroup{"appearance", &BuildOptions::appearance},
        OptionGroup{"orientation", &BuildOptions::orientation},
        OptionGroup{"calibration", &BuildOptions::calibration},
        OptionGroup{"appearance_calibration", &BuildOptions::appearance_calibration},
        OptionField{"images", &BuildOptions::images, AnyValue(), "",
                    "Keep a thumbnail of each keyframe and panorama in the map, for people."},
        OptionField{"image_width", &BuildOptions::image_width, Closed(16, 4096), "px",
                    "Width of a keyframe's thumbnail."},
        OptionField{"threads", &BuildOptions::threads, Closed(0, 1024), "",
                    "Threads for reading and features; 0 takes as many as there are cores. The "
                    "map doesn't depend on it."}};
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// The options as a map records them (MapInfo::options_json).
std::string OptionsJson(const BuildOptions& options);

}  // namespace waystone
