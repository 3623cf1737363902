// SPDX-License-Identifier: Apache-2.0
#include "world/truth.h"

#include <cmath>
#include <limits>

#include "core/base/check.h"

namespace waystone {

Eigen::Matrix3d CalibrationMatrix(const Camera& camera) {
  const bool simple = camera.model == CameraModel::kSimplePinhole;
  WS_CHECK(simple || camera.model == CameraModel::kPinhole, "not a pinhole camera");
  const std::vector<double>& p = camera.params;
  Eigen::Matrix3d k = Eigen::Matrix3d::Identity();
  k(0, 0) = p.at(0);
  k(1, 1) = p.at(simple ? 0 : 1);
  k(0, 2) = p.at(simple ? 1 : 2);
  k(1, 2) = p.at(simple ? 2 : 3);
  return k;
}

// For points with n . x_a = d, x_b = R x_a + t equals (R + t n^T / d) x_a.
Eigen::Matrix3d PlaneHomography(const WorldPlane& plane, const Camera& camera,
                                const Eigen::Isometry3d& world_from_a,
                                const Eigen::Isometry3d& world_from_b) {
  const Eigen::Isometry3d b_from_a = world_from_b.inverse(Eigen::Isometry) * world_from_a;
  const Eigen::Vector3d normal = world_from_a.linear().transpose() * plane.normal;
  const double distance = plane.normal.dot(plane.origin - world_from_a.translation());
  WS_CHECK(std::abs(distance) > std::numeric_limits<double>::epsilon(),
           "the camera lies in the plane");
  const Eigen::Matrix3d k = CalibrationMatrix(camera);
  const Eigen::Matrix3d rays =
      b_from_a.linear() + b_from_a.translation() * normal.transpose() / distance;
  return k * rays * k.inverse();
}

Eigen::Matrix3d ImageFromPlane(const WorldPlane& plane, const Camera& camera,
                               const Eigen::Isometry3d& world_from_camera) {
  const Eigen::Isometry3d camera_from_world = world_from_camera.inverse(Eigen::Isometry);
  Eigen::Matrix3d camera_from_plane;
  camera_from_plane << camera_from_world.linear() * plane.u_axis,
      camera_from_world.linear() * plane.v_axis, camera_from_world * plane.origin;
  return CalibrationMatrix(camera) * camera_from_plane;
}

Eigen::Matrix3d ManhattanDirections(const Eigen::Isometry3d& world_from_camera) {
  return world_from_camera.linear().transpose();
}

std::vector<VisiblePlane> VisiblePlanes(const cv::Mat& plane_ids) {
  WS_CHECK(plane_ids.type() == CV_16UC1, "plane ids are CV_16UC1");
  std::vector<int> counts(size_t{std::numeric_limits<uint16_t>::max()} + 1, 0);
  for (auto id = plane_ids.begin<uint16_t>(); id != plane_ids.end<uint16_t>(); ++id) ++counts[*id];
  std::vector<VisiblePlane> visible;
  for (size_t id = 1; id < counts.size(); ++id) {
    if (counts[id] > 0) visible.push_back({static_cast<int>(id), counts[id]});
  }
  return visible;
}

}  // namespace waystone
