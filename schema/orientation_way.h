// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "schema/orientation_layer.h"

namespace waystone {

// Where the frames of a layer lie in the plane as its turns alone tell it, for drawing the map of
// Puig et al. (2012), fig. 10: the motion follows one of the building's axes, a step of 1 a frame,
// and a confirmed turn has it follow another; where the camera turned alone it goes on. Each
// sequence begins at (0, 0) along the axis nearest to its first known heading. A point a frame, x
// and y along the building's axes. Pure; thread-safe.
std::vector<Eigen::Vector2d> WayOf(const OrientationLayer& layer);

}  // namespace waystone
