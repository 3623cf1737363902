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
#include "core/features/features.h"

namespace waystone {

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
  // Keep a smaller JPEG of each keyframe in the map, for people.
  bool images = true;
  int image_width = 320;  // px
  // Threads for reading and features; 0 takes as many as there are cores. The map doesn't depend
  // on it.
  int threads = 0;

  void Check() const;  // throws MapError(kBadOptions)
};

// The options as a map records them (MapInfo::options_json).
std::string OptionsJson(const BuildOptions& options);

}  // namespace waystone
