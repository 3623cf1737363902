// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "api/json.h"
#include "localizer/index/map_index.h"

// Straight lines of a stored picture by their direction in the building. Takes some 10 ms;
// thread-safe.
namespace waystone {

// width, height (px, in which the points are), of ("frame": the axes are those that the orientation
// layer has for this frame; "picture": the lines' own), reliable, lines {axis, points}.
// For a keyframe, in pixels of the original image. Throws MapError: kNotFound for a map without
// images, kNotAvailable for a sequence without a camera and for panoramas, in whose small pictures
// lines are too short (the nodes of the orientation layer have a picture of the view ahead).
Json LinesJson(const MapIndex& index, const Keyframe& keyframe);
// For a node of the orientation layer, in pixels of its picture. Throws the same.
Json LinesJson(const MapIndex& index, const OrientationNode& node);

}  // namespace waystone
