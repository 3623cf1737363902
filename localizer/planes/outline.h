// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

namespace waystone {

// An outline seen through a homography and clipped to an image of width x height pixels. Parts that
// clipping separates stay one ring, joined along the border. The part beyond the homography's
// horizon, on the other side than `inside` (a point of the outline's image that is certainly in
// front), is cut off first. Empty when nothing is left. Pure; thread-safe.
std::vector<Eigen::Vector2d> ClippedOutline(const std::vector<Eigen::Vector2d>& outline,
                                            const Eigen::Matrix3d& image_from_outline,
                                            const Eigen::Vector2d& inside, int width, int height);

}  // namespace waystone
