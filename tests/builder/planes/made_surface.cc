// SPDX-License-Identifier: Apache-2.0
#include "tests/builder/planes/made_surface.h"

#include "core/homography/homography.h"
#include "tests/builder/planes/made_scene.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

constexpr int kFrameWidth = 640;
constexpr int kFrameHeight = 480;

}  // namespace

void Surface::Add(int count, const Vector2d& low, const Vector2d& high, Random& random) {
  for (int i = 0; i < count; ++i) {
    const double x = random.Uniform(low.x(), high.x());
    points.emplace_back(x, random.Uniform(low.y(), high.y()));
    descriptors.push_back(RandomDescriptor(random));
  }
}

void Surface::Add(const Surface& other) {
  points.insert(points.end(), other.points.begin(), other.points.end());
  descriptors.insert(descriptors.end(), other.descriptors.begin(), other.descriptors.end());
}

Surface RandomSurface(Random& random, int count) {
  Surface surface;
  surface.Add(count, {60, 60}, {580, 420}, random);
  return surface;
}

Plane PlaneOf(int64_t id, int64_t keyframe, const Surface& surface, const Matrix3d& h,
              Random& random) {
  Plane plane;
  plane.id = PlaneId{id};
  plane.reference = KeyframeId{keyframe};
  plane.descriptors = Descriptors(DescriptorBytes(FeatureType::kSift));
  for (size_t i = 0; i < surface.points.size(); ++i) {
    const Vector2d noise(random.Normal(), random.Normal());
    const Vector2d x = Apply(h, surface.points[i]) + 0.2 * noise;
    if (x.x() < 0 || x.y() < 0 || x.x() >= kFrameWidth || x.y() >= kFrameHeight) continue;
    plane.features.push_back({{static_cast<float>(x.x()), static_cast<float>(x.y()), 8, 0}, 3, 4});
    plane.descriptors.Append(surface.descriptors[i].data());
  }
  Matrix3d step = Matrix3d::Identity();
  step(0, 2) = 5;
  plane.views = {{KeyframeId{keyframe}, Matrix3d::Identity(), 50},
                 {KeyframeId{keyframe + 1}, step, 50}};
  return plane;
}

Matrix3d MildHomography(Random& random) {
  const std::vector<Vector2d> corners = {{0, 0}, {640, 0}, {640, 480}, {0, 480}};
  PointPairs pairs;
  for (const Vector2d& corner : corners) {
    const Vector2d moved(random.Uniform(-20, 20), random.Uniform(-20, 20));
    pairs.Add(corner, corner + moved);
  }
  return *HomographyByDlt(pairs);
}

std::vector<Keyframe> Keyframes(int count) {
  std::vector<Keyframe> keyframes(count);
  for (int i = 0; i < count; ++i) {
    keyframes[i].id = KeyframeId{i + 1};
    keyframes[i].width = kFrameWidth;
    keyframes[i].height = kFrameHeight;
  }
  return keyframes;
}

}  // namespace waystone
