// SPDX-License-Identifier: Apache-2.0
#include "localizer/planes/outline.h"

#include <Eigen/Dense>

#include "core/homography/homography.h"

namespace waystone {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Polygon = std::vector<Vector2d>;

// The part of a polygon where line . (x, y, 1) >= 0 (Sutherland and Hodgman, one edge).
Polygon ClipToHalfPlane(const Polygon& polygon, const Vector3d& line) {
  Polygon clipped;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d& here = polygon[i];
    const Vector2d& next = polygon[(i + 1) % polygon.size()];
    const double d_here = line.dot(here.homogeneous());
    const double d_next = line.dot(next.homogeneous());
    if (d_here >= 0) clipped.push_back(here);
    if ((d_here >= 0) != (d_next >= 0)) {
      clipped.push_back(here + (next - here) * (d_here / (d_here - d_next)));
    }
  }
  return clipped;
}

}  // namespace

Polygon ClippedOutline(const Polygon& outline, const Eigen::Matrix3d& image_from_outline,
                       const Vector2d& inside, int width, int height) {
  // A margin excludes the horizon itself: points there have no image.
  constexpr double kMargin = 0.05;
  Vector3d horizon = image_from_outline.row(2);
  horizon /= horizon.dot(inside.homogeneous());  // 1 at `inside`, 0 on the horizon
  horizon.z() -= kMargin;
  Polygon polygon = ClipToHalfPlane(outline, horizon);
  for (Vector2d& x : polygon) x = Apply(image_from_outline, x);
  for (const Vector3d& side : {Vector3d(1, 0, 0), Vector3d(0, 1, 0), Vector3d(-1, 0, width - 1.0),
                               Vector3d(0, -1, height - 1.0)}) {
    polygon = ClipToHalfPlane(polygon, side);
  }
  return polygon;
}

}  // namespace waystone
