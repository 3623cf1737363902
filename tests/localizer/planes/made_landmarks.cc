// SPDX-License-Identifier: Apache-2.0
#include "tests/localizer/planes/made_landmarks.h"

#include <algorithm>
#include <cmath>

#include "core/features/descriptor_codes.h"

namespace waystone {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kPoints = 120;

// As the builder has them: squares of normals, of length 256.
std::vector<uint8_t> MakeDescriptor(Random& random) {
  Eigen::VectorXd values(128);
  for (double& value : values) value = std::pow(random.Normal(), 2);
  values *= 256 / values.norm();
  std::vector<uint8_t> descriptor;
  for (const double value : values) {
    descriptor.push_back(static_cast<uint8_t>(std::min(std::lround(value), 127L)));
  }
  return descriptor;
}

bool IsSeen(const Vector2d& x) { return x.x() >= 0 && x.y() >= 0 && x.x() < 640 && x.y() < 480; }

}  // namespace

std::vector<Point> MakePoints(uint64_t seed) {
  Random random(seed);
  std::vector<Point> points;
  for (int i = 0; i < kPoints; ++i) {
    const double z = random.Uniform(2, 8);
    points.push_back({{random.Uniform(-0.6, 0.6) * z, random.Uniform(-0.45, 0.45) * z, z},
                      MakeDescriptor(random)});
  }
  return points;
}

Vector2d Project(const Vector3d& x) { return 500 * x.hnormalized() + Vector2d(319.5, 239.5); }

Features Look(const std::vector<Point>& points, const Vector3d& shift, int clutter, uint64_t seed) {
  Random random(5000 + seed);
  Features features{FeatureType::kSift, 640, 480, 640, 480, {}, Descriptors(128), {}};
  const auto add = [&](const Vector2d& x, const std::vector<uint8_t>& descriptor) {
    if (!IsSeen(x)) return;
    features.keypoints.push_back({static_cast<float>(x.x()), static_cast<float>(x.y()), 8, 0});
    features.descriptors.Append(descriptor.data());
  };
  for (const Point& point : points) {
    add(Project(point.x - shift) + 0.3 * Vector2d(random.Normal(), random.Normal()),
        point.descriptor);
  }
  for (int i = 0; i < clutter; ++i) {
    add({random.Uniform(0, 640), random.Uniform(0, 480)}, MakeDescriptor(random));
  }
  return features;
}

Landmarks MakeLandmarks(const Features& seen) {
  Landmarks landmarks;
  for (const Keypoint& keypoint : seen.keypoints) {
    landmarks.positions.push_back(EncodePosition(PositionOf(keypoint), 640, 480));
  }
  landmarks.codes = EncodeDescriptors(seen.descriptors, FeatureType::kSift);
  return landmarks;
}

MapData MapWithLandmarks() {
  MapData map = MadeMap();
  const std::vector<Point> points = MakePoints(1);
  for (int i = 0; i < 2; ++i) {
    Keyframe keyframe = map.keyframes.back();
    keyframe.id = KeyframeId{kLandmarkKeyframe + i};
    keyframe.stretch = 2;
    keyframe.source = "landmarks/" + std::to_string(i);
    keyframe.landmarks = MakeLandmarks(Look(points, {0.3 * i, 0, 0}, 0, i));
    map.keyframes.push_back(keyframe);
  }
  return map;
}

}  // namespace waystone
