// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "schema/layers/orientation/orientation_layer.h"

namespace waystone {

// Where a rig looks in the building: 0 along its x, pi / 2 along its y. rad, (-pi, pi]. Nothing for
// a rig that looks straight up or down. Pure; thread-safe.
std::optional<double> HeadingOf(const BuildingRotation& rotation);

// Where the frames of a layer lie in the plane by its turns only, for drawing the map of Puig et
// al. (2012), fig. 10: one step of length 1 per frame along one of the building's axes, which
// changes at confirmed turns; where only the camera turned the motion goes on. Between two turns it
// follows the axis set by the first one, in the direction in which most frames look; where they
// look across it, in the direction of the turn. Each sequence begins at (0, 0). One point per
// frame, x and y along the building's axes. Pure; thread-safe.
std::vector<Eigen::Vector2d> ComputeTrajectory(const OrientationLayer& layer);

}  // namespace waystone
