// SPDX-License-Identifier: Apache-2.0
#include "core/manhattan/great_circles.h"

#include <Eigen/Geometry>
#include <cmath>
#include <optional>

#include "core/base/check.h"
#include "core/base/error.h"

namespace waystone {
namespace {

// Angle of a step of one pixel across the segment at its middle.
double PixelAngle(const Camera& camera, const ImageSegment& segment) {
  const Eigen::Vector2d middle = 0.5 * (segment.a + segment.b);
  const Eigen::Vector2d along = (segment.b - segment.a).normalized();
  const Eigen::Vector2d across(-along.y(), along.x());
  const Eigen::Vector3d left = Unproject(camera, middle - 0.5 * across);
  return left.cross(Unproject(camera, middle + 0.5 * across)).norm();
}

std::optional<GreatCircle> FitCircle(const RigCamera& seen, const ImageSegment& segment,
                                     const GreatCircleOptions& options) {
  const Eigen::Vector3d a = Unproject(seen.camera, segment.a);
  const Eigen::Vector3d b = Unproject(seen.camera, segment.b);
  const Eigen::Vector3d cross = a.cross(b);
  if (!(cross.norm() > 0) || a.dot(b) < 0) return std::nullopt;
  const Eigen::Vector3d normal = cross.normalized();
  const double pixel_rad = PixelAngle(seen.camera, segment);
  const Eigen::Vector3d seen_middle = Unproject(seen.camera, 0.5 * (segment.a + segment.b));
  if (std::abs(normal.dot(seen_middle)) > options.max_sag_px * pixel_rad) return std::nullopt;
  const Eigen::Matrix3d rotation = seen.rig_from_camera.linear();
  GreatCircle circle;
  circle.normal = rotation * normal;
  circle.middle = rotation * (a + b).normalized();
  circle.along = circle.normal.cross(circle.middle);
  circle.length_rad = std::atan2(cross.norm(), a.dot(b));
  circle.end_sigma_rad = options.end_sigma_px * pixel_rad;
  circle.segment = segment;
  return circle;
}

}  // namespace

void GreatCircleOptions::Check() const { CheckFields("circles", *this); }

std::vector<GreatCircle> FindGreatCircles(const Rig& rig, int camera,
                                          std::span<const ImageSegment> segments,
                                          const GreatCircleOptions& options) {
  options.Check();
  WS_CHECK(camera >= 0 && camera < static_cast<int>(rig.cameras.size()), "no such camera");
  std::vector<GreatCircle> circles;
  for (const ImageSegment& segment : segments) {
    auto circle = FitCircle(rig.cameras[camera], segment, options);
    if (!circle) continue;
    circle->camera = camera;
    circles.push_back(*circle);
  }
  return circles;
}

}  // namespace waystone
