// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/base/random.h"
#include "core/homography/homography.h"

namespace waystone {

// A plane in the frame of image a: the points X with n . X = d.
struct MadePlane {
  Eigen::Vector3d n = Eigen::Vector3d::UnitZ();
  double d = 1;
};

// Two images a and b of one camera that moved: X_b = R X_a - t, as in the paper, so that a plane's
// homography is H = K (R - t n^T / d) K^-1 with x_b = H x_a.
struct MadeViews {
  Eigen::Matrix3d k = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d r = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();

  Eigen::Matrix3d HomographyOf(const MadePlane& plane) const;  // b_from_a, not normalised
};

inline constexpr int kMadeWidth = 640;
inline constexpr int kMadeHeight = 480;

// A random camera that turned by up to 0.25 rad and moved by 0.4 to 0.8 units.
MadeViews RandomViews(Random& random);

// A random plane that faces the camera, 2 to 5 units off along the optical axis, and less than
// about 60 degrees from fronto-parallel.
MadePlane RandomPlane(Random& random);

// A point of the box [x, x + width] x [y, y + height].
Eigen::Vector2d RandomPoint(Random& random, double x = 0, double y = 0, double width = kMadeWidth,
                            double height = kMadeHeight);

// A homography between two images as a hand-held camera gives them.
Eigen::Matrix3d RandomHomography(Random& random);

// `count` points of the box and their images under a homography, both with normal noise.
struct Box {
  double x = 0;
  double y = 0;
  double width = kMadeWidth;
  double height = kMadeHeight;
};
PointPairs PairsOf(const Eigen::Matrix3d& b_from_a, int count, double sigma_px, Random& random,
                   const Box& box = {});

// The largest distance between the images of a grid over the image under two homographies.
double LargestDifference(const Eigen::Matrix3d& g, const Eigen::Matrix3d& h);

}  // namespace waystone
