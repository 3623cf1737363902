// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/base/random.h"
#include "core/camera/camera.h"
#include "core/features/features.h"

namespace waystone {

// A descriptor like no other: two of them are about three quarters of the largest distance apart.
std::vector<uint8_t> RandomDescriptor(Random& random);

// 640x480, focal length 500 px, no distortion.
Camera MadeCamera();

// A rectangle in the world: corner + u along + v down, u and v in [0, 1].
struct MadeWall {
  Eigen::Vector3d corner;
  Eigen::Vector3d along;
  Eigen::Vector3d down;
};

struct MadePoint {
  Eigen::Vector3d x_world;
  int wall = 0;
  std::vector<uint8_t> descriptor;
};

// Points on walls, and what MadeCamera sees of them: keypoints at their projections, with the
// point's own descriptor. World frame: as the camera's at the origin, metres.
class MadeScene {
 public:
  explicit MadeScene(uint64_t seed) : random_(seed) {}

  // Returns the wall's number.
  int AddWall(const MadeWall& wall, int points);

  // The keypoints have normal noise of `sigma_px`; points that `detected` refuses are left out.
  using Detected = std::function<bool(int point)>;
  Features See(const Eigen::Isometry3d& world_from_camera, double sigma_px = 0.2,
               const Detected& detected = {});

  // x_b = b_from_a x_a for points of the wall.
  Eigen::Matrix3d HomographyOf(int wall, const Eigen::Isometry3d& world_from_a,
                               const Eigen::Isometry3d& world_from_b) const;
  // Number of the point with a descriptor, or -1.
  int PointOf(const uint8_t* descriptor) const;

  const std::vector<MadePoint>& points() const { return points_; }
  Random& random() { return random_; }

 private:
  Random random_;
  std::vector<MadeWall> walls_;
  std::vector<MadePoint> points_;
};

constexpr int kPointsOfWall = 120;  // of a corner's

// The corner of a room, both walls always in view.
MadeScene CornerScene(uint64_t seed);

// A camera that passes the corner from left to right.
Eigen::Isometry3d PassingPose(int frame);

// A camera at a place that looks along z, turned by `yaw_rad` around its y axis.
Eigen::Isometry3d PoseAt(double x, double y, double z, double yaw_rad = 0);

}  // namespace waystone
