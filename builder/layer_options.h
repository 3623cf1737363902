// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "builder/build_options.h"
#include "builder/planes/plane_layer.h"
#include "schema/map_data.h"

// What the options of a build mean for its parts.
namespace waystone {

// Name, program, feature type and the record of the options.
MapInfo MakeMapInfo(const BuildOptions& options);

// Of each layer: without thumbnails where a map keeps no images, with as many samples as its
// calibration takes, and with the features of the build.
PlaneBuildOptions MakePlaneOptions(const BuildOptions& options);
AppearanceOptions MakeAppearanceOptions(const BuildOptions& options);
OrientationOptions MakeOrientationOptions(const BuildOptions& options);

}  // namespace waystone
