// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "builder/build_options.h"
#include "builder/planes/plane_layer.h"
#include "schema/map_data.h"

// Derives the options of a build's parts from those of the build. All are pure; thread-safe.
namespace waystone {

// Name, program, feature type and the record of the options.
MapInfo MakeMapInfo(const BuildOptions& options);

// The options of each layer: without thumbnails where a map keeps no images, with as many samples
// as its calibration takes, and with the features of the build.
PlaneBuildOptions MakePlaneOptions(const BuildOptions& options);
AppearanceOptions MakeAppearanceOptions(const BuildOptions& options);
OrientationOptions MakeOrientationOptions(const BuildOptions& options);

}  // namespace waystone
