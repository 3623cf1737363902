// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "api/json.h"
#include "localizer/index/map_index.h"

namespace waystone {

// The pose layer. Throws MapError(kNoLayer) for a map without poses. Thread-safe.
const PoseLayer& PosesOf(const MapIndex& index);

// The whole pose layer for drawing, lengths in its unit, points and directions in its frame: the
// schema PoseLayer of clients/openapi.yaml. Orientations (x, y, z, w) turn the axes of the camera
// (x right, y down, z forward) into those of the frame; a plane has the points X with normal . X =
// distance. Its outline is that in the reference image, projected to the plane, without points that
// the image shows at too flat an angle; it is empty where the reference has no pose or camera. `up`
// is the mean direction of the tops of images, null where these differ too much. `layer` is that of
// `index`. Thread-safe.
Json PoseLayerJson(const MapIndex& index, const PoseLayer& layer);

}  // namespace waystone
