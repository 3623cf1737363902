// SPDX-License-Identifier: Apache-2.0
#include "builder/layer_options.h"

#include <string>

#include "builder/options_record.h"
#include "core/base/version.h"

namespace waystone {

MapInfo MakeMapInfo(const BuildOptions& options) {
  MapInfo info;
  info.name = options.map_name;
  info.program = std::string("waystone ") + kVersion;
  info.feature_type = options.features.type;
  info.options_json = RecordOptions(options);
  return info;
}

PlaneBuildOptions MakePlaneOptions(const BuildOptions& options) {
  return {.features = options.features,
          .keyframes = options.keyframes,
          .planes = options.planes,
          .image_width = options.images ? options.image_width : 0,
          .max_samples = options.calibration.max_keyframes};
}

AppearanceOptions MakeAppearanceOptions(const BuildOptions& options) {
  AppearanceOptions appearance = options.appearance;
  if (!options.images) appearance.describe.image_width = 0;
  appearance.max_samples = options.appearance_calibration.max_nodes;
  appearance.describe.features.extract.bearings.features.type = options.features.type;
  return appearance;
}

OrientationOptions MakeOrientationOptions(const BuildOptions& options) {
  OrientationOptions orientation = options.orientation;
  if (!options.images) orientation.image_width = 0;
  return orientation;
}

}  // namespace waystone
