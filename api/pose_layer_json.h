// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "api/json.h"
#include "localizer/index/map_index.h"

namespace waystone {

// The pose layer. Throws MapError(kNoLayer) for a map that was built without poses.
const PoseLayer& PosesOf(const MapIndex& index);

// The whole pose layer for drawing, lengths in its unit, points and directions in its frame:
//   frame, unit  as in the layer
//   noise        {position_deviation, rotation_deviation_rad} of the given poses, on each axis;
//                null where none was measured
//   up           of unit length: the mean of the directions in which the images of the keyframes
//                have their top; null where these differ too much to have one
//   keyframes    columns, ordered by id: id, position, orientation (x, y, z, w: turns the axes of
//                the camera, x right, y down, z forward, into those of the frame)
//   planes       {id, reference, normal, distance, outline}, ordered by id: points X with
//                normal . X = distance. The outline is that of the plane's features in the
//                reference image, as such points, but for those that the image shows too flatly;
//                empty where the reference keyframe has no pose or camera.
// `layer` is that of `index`. Thread-safe.
Json PoseLayerJson(const MapIndex& index, const PoseLayer& layer);

}  // namespace waystone
