// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/features/features.h"

// How points are spread over an image: many in one spot say little about where it was taken.
namespace waystone {

// Whether features at x (px) can be expected to be found in an image: it isn't clipped there, and
// the border is well away.
bool CanShow(const Features& image, const Eigen::Vector2d& x);

// Points of which none is nearer than `apart` to one counted before; both in px.
int CountApart(const std::vector<Eigen::Vector2d>& points, double apart);

// Keypoints of one image that are independent of each other: a corner gives features of many sizes,
// which are found again together or not at all. SIFT features are independent where what they see
// hardly overlaps; ORB's and AKAZE's from a smaller distance, which was chosen on rendered
// buildings.
int CountIndependent(std::vector<Keypoint> keypoints, FeatureType type);

// Share of a width x height image that is near a point, in [0, 1]: within a disc around it of a
// fortieth of the image's area. The points lie inside.
double ComputeCoverage(const std::vector<Eigen::Vector2d>& points, int width, int height);

}  // namespace waystone
