// SPDX-License-Identifier: Apache-2.0
#include "tests/core/homography/made_views.h"

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>

namespace waystone {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

Vector3d RandomDirection(Random& random) {
  Vector3d v(random.Normal(), random.Normal(), random.Normal());
  return v.normalized();
}

}  // namespace

Matrix3d MadeViews::HomographyOf(const MadePlane& plane) const {
  return k * (r - t * plane.n.transpose() / plane.d) * k.inverse();
}

MadeViews RandomViews(Random& random) {
  MadeViews views;
  const double f = random.Uniform(450, 700);
  views.k << f, 0, random.Uniform(300, 340), 0, f * random.Uniform(0.98, 1.02),
      random.Uniform(220, 260), 0, 0, 1;
  views.r = Eigen::AngleAxisd(random.Uniform(-0.25, 0.25), RandomDirection(random)).matrix();
  views.t = random.Uniform(0.4, 0.8) * RandomDirection(random);
  return views;
}

MadePlane RandomPlane(Random& random) {
  MadePlane plane;
  plane.n = Vector3d(random.Uniform(-1, 1), random.Uniform(-1, 1), 1).normalized();
  plane.d = plane.n.z() * random.Uniform(2, 5);
  return plane;
}

Vector2d RandomPoint(Random& random, double x, double y, double width, double height) {
  const double right = random.Uniform(x, x + width);
  return {right, random.Uniform(y, y + height)};
}

Matrix3d RandomHomography(Random& random) {
  return Normalised(RandomViews(random).HomographyOf(RandomPlane(random)));
}

PointPairs PairsOf(const Matrix3d& b_from_a, int count, double sigma_px, Random& random,
                   const Box& box) {
  PointPairs pairs;
  for (int i = 0; i < count; ++i) {
    const Vector2d a = RandomPoint(random, box.x, box.y, box.width, box.height);
    const Vector2d b = Apply(b_from_a, a);
    const Vector2d noise_a(random.Normal(), random.Normal());
    const Vector2d noise_b(random.Normal(), random.Normal());
    pairs.Add(a + sigma_px * noise_a, b + sigma_px * noise_b);
  }
  return pairs;
}

double LargestDifference(const Matrix3d& g, const Matrix3d& h) {
  double largest = 0;
  for (int x = 0; x <= kMadeWidth; x += kMadeWidth / 8) {
    for (int y = 0; y <= kMadeHeight; y += kMadeHeight / 6) {
      largest = std::max(largest, (Apply(g, Vector2d(x, y)) - Apply(h, Vector2d(x, y))).norm());
    }
  }
  return largest;
}

}  // namespace waystone
