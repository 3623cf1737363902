// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "api/json.h"
#include "localizer/index/map_index.h"

namespace waystone {

// The pose layer. Throws MapError(kNoLayer) for a map that was built without poses.
const PoseLayer& PosesOf(const MapIndex& index);

// The whole pose layer for drawing, lengths in its unit, points and directions in its frame: the
// schema PoseLayer of clients/openapi.yaml. Orientations (x, y, z, w) turn the axes of the camera
// (x right, y down, z forward) into those of the frame; a plane has the points X with
// normal . X = distance. Its outline is that of its features in the reference image, but for those
// that the image shows too flatly; it is empty where the reference has no pose or camera. `up` is
// the mean of the directions in which images have their top, null where these differ too much.
// `layer` is that of `index`. Thread-safe.
Json PoseLayerJson(const MapIndex& index, const PoseLayer& layer);

}  // namespace waystone
