// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/features/features.h"
#include "schema/map_data.h"

namespace waystone {

// A keypoint as another image would show it: position, scale and angle by the homography's local
// affinity. Functions that return values are pure; the others are thread-safe for different planes.
Keypoint Transferred(const Eigen::Matrix3d& b_from_a, const Keypoint& keypoint_a);

// Keeps the features `kept` (ascending) and their descriptors, drops the others.
void KeepFeatures(std::span<const int> kept, Plane& plane);

// From a plane with more than `plenty` features, drops those with fewer than `min_votes` votes,
// those with the fewest first, as long as more than `plenty` are left. The order is kept.
void DropSparseFeatures(int plenty, int min_votes, Plane& plane);

// Whether a position is inside a reference image of width x height pixels or at most
// `max_extrapolation` image sizes outside it.
bool IsWithinReach(const Eigen::Vector2d& reference, int width, int height,
                   double max_extrapolation);

// The positions of the features in the reference image, px.
std::vector<Eigen::Vector2d> PositionsOf(const Plane& plane);

}  // namespace waystone
