// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <vector>

#include "core/camera/camera.h"
#include "world/faces.h"

namespace waystone {

// The calibration matrix of a pinhole camera without distortion (kSimplePinhole, kPinhole); a
// CheckFailure for any other model. All functions here are pure; thread-safe.
Eigen::Matrix3d CalibrationMatrix(const Camera& camera);

// The homography that a plane induces between two views of one pinhole camera: x_b = H x_a for
// homogeneous pixels of points on the plane. It is scaled so that the third coordinate of H x_a,
// for x_a = (x, y, 1), is the point's depth in b over that in a: positive where both see it. The
// camera's centre in a must not lie in the plane (CheckFailure); H is singular where b's does.
Eigen::Matrix3d PlaneHomography(const WorldPlane& plane, const Camera& camera,
                                const Eigen::Isometry3d& world_from_a,
                                const Eigen::Isometry3d& world_from_b);

// The homography from a plane's own (u, v, 1), metres, to homogeneous pixels; the third coordinate
// is the depth in metres.
Eigen::Matrix3d ImageFromPlane(const WorldPlane& plane, const Camera& camera,
                               const Eigen::Isometry3d& world_from_camera);

// The building's directions in the camera's frame: columns are east, north and up (unit). Each is
// also the vanishing point of the edges that run along it.
Eigen::Matrix3d ManhattanDirections(const Eigen::Isometry3d& world_from_camera);

struct VisiblePlane {
  int plane = 0;
  int pixels = 0;
  bool operator==(const VisiblePlane&) const = default;
};

// Which planes a frame shows, by ascending id. Takes RenderedFrame::plane_ids (CV_16UC1).
std::vector<VisiblePlane> VisiblePlanes(const cv::Mat& plane_ids);

}  // namespace waystone
