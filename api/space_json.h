// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "api/json.h"
#include "localizer/index/map_index.h"

namespace waystone {

// What a keyframe sees in space, in its camera's frame (x right, y down, z forward):
//   keyframe           its id
//   views              other keyframes that it was found with
//   unit_plane         the plane whose distance is the unit; null where nothing is known
//   image_from_camera  the camera's linear part, px: x_image = K x_camera
//   corners            rays through the image's corners, z = 1, clockwise from the upper left
//   planes             {id, trouble, normal, distance, normal_deviation_rad, distance_deviation,
//                      outline}: points X with normal . X = distance; the outline are such points.
//                      A plane that isn't well determined has its trouble (core/homography/
//                      plane_in_space.h) and no place.
// Throws MapError(kNotAvailable) for a sequence without a camera and for panoramas. Takes up to
// about 100 ms; thread-safe.
Json SpaceJson(const MapIndex& index, const Keyframe& keyframe);

}  // namespace waystone
