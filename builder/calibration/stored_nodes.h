// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "builder/calibration/appearance_calibration.h"
#include "schema/map_data.h"

namespace waystone {

// CalibrateAppearanceLayer of a finished map, whose images are gone, by the signatures and features
// that its nodes keep: at most options.max_nodes, evenly spread. They have fewer features than a
// new panorama gives. The errors of answers in the frame of poses are measured again where the map
// has poses of panoramas. The map has an appearance layer (WS_CHECK). Deterministic, on any number
// of threads.
void RecalibrateAppearanceLayer(MapData& map, const AppearanceCalibrationOptions& options);

}  // namespace waystone
