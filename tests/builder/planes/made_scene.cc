// SPDX-License-Identifier: Apache-2.0
#include "tests/builder/planes/made_scene.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace waystone {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr double kFocal_px = 500;
constexpr int kWidth = 640;
constexpr int kHeight = 480;

Matrix3d Calibration() {
  Matrix3d k;
  k << kFocal_px, 0, 0.5 * (kWidth - 1), 0, kFocal_px, 0.5 * (kHeight - 1), 0, 0, 1;
  return k;
}

}  // namespace

std::vector<uint8_t> RandomDescriptor(Random& random) {
  Eigen::VectorXd values(DescriptorBytes(FeatureType::kSift));
  for (double& value : values) {
    const double normal = random.Normal();
    value = normal * normal;
  }
  values *= 256 / values.norm();
  std::vector<uint8_t> descriptor;
  for (double value : values) {
    descriptor.push_back(static_cast<uint8_t>(std::min(std::lround(value), 127L)));
  }
  return descriptor;
}

Camera MadeCamera() {
  return {CameraModel::kPinhole,
          kWidth,
          kHeight,
          {kFocal_px, kFocal_px, 0.5 * (kWidth - 1), 0.5 * (kHeight - 1)}};
}

int MadeScene::AddWall(const MadeWall& wall, int points) {
  const int number = static_cast<int>(walls_.size());
  walls_.push_back(wall);
  for (int i = 0; i < points; ++i) {
    const double u = random_.Uniform();
    const double v = random_.Uniform();
    points_.push_back(
        {wall.corner + u * wall.along + v * wall.down, number, RandomDescriptor(random_)});
  }
  return number;
}

Features MadeScene::See(const Isometry3d& world_from_camera, double sigma_px,
                        const Detected& detected) {
  Features features{FeatureType::kSift, kWidth, kHeight, kWidth, kHeight, {}, Descriptors(128), {}};
  const Isometry3d camera_from_world = world_from_camera.inverse();
  for (int i = 0; i < static_cast<int>(points_.size()); ++i) {
    const Vector3d x = camera_from_world * points_[i].x_world;
    const Vector2d noise(random_.Normal(), random_.Normal());
    if (x.z() <= 0.1 || (detected && !detected(i))) continue;
    const Vector2d pixel = (Calibration() * x).hnormalized() + sigma_px * noise;
    if (pixel.x() < 0 || pixel.y() < 0 || pixel.x() >= kWidth || pixel.y() >= kHeight) continue;
    features.keypoints.push_back(
        {static_cast<float>(pixel.x()), static_cast<float>(pixel.y()), 8, 0});
    features.descriptors.Append(points_[i].descriptor.data());
  }
  return features;
}

Matrix3d MadeScene::HomographyOf(int wall, const Isometry3d& world_from_a,
                                 const Isometry3d& world_from_b) const {
  const MadeWall& w = walls_.at(wall);
  const Vector3d normal = w.along.cross(w.down).normalized();
  const Vector3d n = world_from_a.linear().transpose() * normal;
  const double d = normal.dot(w.corner - world_from_a.translation());
  const Isometry3d b_from_a = world_from_b.inverse() * world_from_a;
  return Calibration() * (b_from_a.linear() + b_from_a.translation() * n.transpose() / d) *
         Calibration().inverse();
}

int MadeScene::PointOf(const uint8_t* descriptor) const {
  for (int i = 0; i < static_cast<int>(points_.size()); ++i) {
    if (std::equal(points_[i].descriptor.begin(), points_[i].descriptor.end(), descriptor)) {
      return i;
    }
  }
  return -1;
}

Isometry3d PoseAt(double x, double y, double z, double yaw_rad) {
  Isometry3d pose = Isometry3d::Identity();
  pose.translation() = Vector3d(x, y, z);
  pose.linear() = Eigen::AngleAxisd(yaw_rad, Vector3d::UnitY()).matrix();
  return pose;
}

MadeScene CornerScene(uint64_t seed) {
  MadeScene scene(seed);
  scene.AddWall({{-1.6, -1.3, 4}, {1.5, 0, 2}, {0, 2.6, 0}}, kPointsOfWall);
  scene.AddWall({{0.1, -1.3, 6}, {1.5, 0, -2}, {0, 2.6, 0}}, kPointsOfWall);
  return scene;
}

Eigen::Isometry3d PassingPose(int frame) {
  return PoseAt(-0.84 + 0.24 * frame, 0.02 * frame, 0.02 * frame, 0.07 - 0.02 * frame);
}

}  // namespace waystone
