// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/features/features.h"

// How points are spread over an image: many in one spot say little about where it was taken. All
// functions are pure; thread-safe.
namespace waystone {

// Whether features at x (px) can be expected to be found in an image: it isn't clipped there, and
// the border isn't near.
bool CanShow(const Features& image, const Eigen::Vector2d& x);

// Counts points, skipping those nearer than `apart` to one already counted; both in px.
int CountApart(const std::vector<Eigen::Vector2d>& points, double apart);

// Counts the independent keypoints of one image: a corner gives features of many sizes, which are
// found again together or not at all. SIFT features are independent where their regions hardly
// overlap; ORB's and AKAZE's beyond a smaller distance, which was chosen on rendered buildings.
int CountIndependent(std::vector<Keypoint> keypoints, FeatureType type);

// Share of a width x height image that is near any of the points, in [0, 1]: within a disc of a
// fortieth of the image's area around it. The points lie inside.
double ComputeCoverage(const std::vector<Eigen::Vector2d>& points, int width, int height);

}  // namespace waystone
