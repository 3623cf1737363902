// SPDX-License-Identifier: Apache-2.0
#include "tests/localizer/made_map.h"

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <numeric>

#include "core/homography/homography.h"

namespace waystone {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;
constexpr int kSiftBytes = 128;

// A plane n . X = d of the world, and the box of keyframe 1's image where its features lie.
struct MadeWall {
  Vector3d n;
  double d;
  double x, y, width, height;
  int reference;               // keyframe
  std::vector<int> keyframes;  // that saw it
};

const std::array<MadeWall, 4>& Walls() {
  static const std::array<MadeWall, 4> walls = {{
      {{0, 0, 1}, 4, 60, 60, 270, 240, 1, {1, 2, 3}},
      {{1, 0, 0.1}, 1.5, 420, 40, 190, 400, 1, {1, 2, 3, 4}},
      {{0, 1, 0.1}, 1.3, 80, 340, 320, 120, 3, {3, 4}},
      {{0, 0, 1}, 4, 60, 60, 270, 240, 5, {5, 6}},
  }};
  return walls;
}

const MadeWall& WallOf(int64_t plane) { return Walls()[static_cast<size_t>(plane - 1)]; }

Matrix3d CameraMatrix() {
  Matrix3d k;
  k << 500, 0, 319.5, 0, 500, 239.5, 0, 0, 1;
  return k;
}

// x_camera = H x_world's camera.
Matrix3d CameraFromWorld(const MadeWall& wall, const MadePose& pose) {
  const Matrix3d k = CameraMatrix();
  return k * (pose.r - pose.t * wall.n.transpose() / wall.d) * k.inverse();
}

std::vector<uint8_t> RandomDescriptor(Random& random) {
  std::vector<uint8_t> descriptor(kSiftBytes);
  for (uint8_t& byte : descriptor) byte = random.Below(60);
  return descriptor;
}

Plane MakePlane(int64_t id, Random& random) {
  const MadeWall& wall = WallOf(id);
  const Matrix3d reference_from_world = CameraFromWorld(wall, PoseOf(wall.reference));
  Plane plane;
  plane.id = PlaneId{id};
  plane.reference = KeyframeId{wall.reference};
  plane.descriptors = Descriptors(kSiftBytes);
  for (int i = 0; i < kMapFeatures; ++i) {
    const Vector2d x = Apply(reference_from_world, {random.Uniform(wall.x, wall.x + wall.width),
                                                    random.Uniform(wall.y, wall.y + wall.height)});
    plane.features.push_back({{static_cast<float>(x.x()), static_cast<float>(x.y()), 8, 0}, 3, 3});
    plane.descriptors.Append(RandomDescriptor(random).data());
  }
  for (const Vector2d& corner : {Vector2d(wall.x, wall.y), Vector2d(wall.x + wall.width, wall.y),
                                 Vector2d(wall.x + wall.width, wall.y + wall.height),
                                 Vector2d(wall.x, wall.y + wall.height)}) {
    plane.outline.push_back(Apply(reference_from_world, corner));
  }
  for (int keyframe : wall.keyframes) {
    const Matrix3d keyframe_from_world = CameraFromWorld(wall, PoseOf(keyframe));
    plane.views.push_back({KeyframeId{keyframe},
                           Normalised(reference_from_world * keyframe_from_world.inverse()),
                           kMapFeatures});
  }
  return plane;
}

Edge MakeEdge(int64_t a, int64_t b, int from, int to) {
  const auto to_from = [&](int64_t plane) -> Matrix3d {
    const MadeWall& wall = WallOf(plane);
    return CameraFromWorld(wall, PoseOf(to)) * CameraFromWorld(wall, PoseOf(from)).inverse();
  };
  Edge edge{PlaneId{a}, PlaneId{b}, KeyframeId{from}, KeyframeId{to}, Matrix3d::Identity(), 1};
  edge.homology = to_from(a).inverse() * to_from(b);
  return edge;
}

struct SeenFeature {
  Keypoint keypoint;
  std::vector<uint8_t> descriptor;
};

Features Assembled(const std::vector<SeenFeature>& seen) {
  Features features;
  features.width = kWidth;
  features.height = kHeight;
  features.descriptors = Descriptors(kSiftBytes);
  for (const SeenFeature& feature : seen) {
    features.keypoints.push_back(feature.keypoint);
    features.descriptors.Append(feature.descriptor.data());
  }
  return features;
}

template <class Value>
void Shuffle(std::vector<Value>& values, Random& random) {
  for (int i = static_cast<int>(values.size()) - 1; i > 0; --i) {
    std::swap(values[i], values[random.Below(i + 1)]);
  }
}

}  // namespace

MadePose PoseOf(double keyframe) {
  // Keyframes 5 and 6 look at their wall as 1 and 2 do at theirs.
  const double steps = keyframe >= 5 ? keyframe - 5 : keyframe - 1;
  MadePose pose;
  pose.r = Eigen::AngleAxisd(-0.03 * steps, Vector3d::UnitY()).matrix();
  pose.t = Vector3d(0.08 * steps, 0.02 * steps, 0.1 * steps);
  return pose;
}

Matrix3d ReferenceFromQuery(int64_t plane, const MadePose& query) {
  const MadeWall& wall = WallOf(plane);
  return Normalised(CameraFromWorld(wall, PoseOf(wall.reference)) *
                    CameraFromWorld(wall, query).inverse());
}

MapData MadeMap() {
  MapData map;
  map.info.name = "made";
  map.info.version = "sha256:0";
  map.sequences.push_back({SequenceId{1}, "walk", "folder", 60, 0, std::nullopt});
  for (int id = 1; id <= 6; ++id) {
    Keyframe keyframe;
    keyframe.id = KeyframeId{id};
    keyframe.sequence = SequenceId{1};
    keyframe.stretch = id >= 5;
    keyframe.frame = 10 * id;
    keyframe.source = "rgb/" + std::to_string(10 * id) + ".jpg";
    keyframe.time_s = 0.5 * id;
    keyframe.width = kWidth;
    keyframe.height = kHeight;
    map.keyframes.push_back(keyframe);
  }
  Random random(1);
  for (int64_t id = 1; id <= 4; ++id) map.planes.push_back(MakePlane(id, random));
  map.edges = {MakeEdge(1, 2, 1, 2), MakeEdge(2, 3, 3, 4)};
  return map;
}

std::shared_ptr<const MapIndex> MadeIndex() { return MapIndex::Build(MadeMap()); }

Features QueryOf(const MapData& map, const std::vector<int64_t>& planes, const MadePose& pose,
                 int clutter, uint64_t seed) {
  Random random(1000 + seed);  // the map has the seed 1: its descriptors must not come again
  std::vector<SeenFeature> seen;
  for (int64_t id : planes) {
    const Plane& plane = map.planes[static_cast<size_t>(id - 1)];
    const Matrix3d query_from_reference = ReferenceFromQuery(id, pose).inverse();
    for (int i = 0; i < static_cast<int>(plane.features.size()); ++i) {
      const Keypoint& reference = plane.features[i].reference;
      const Vector2d x = Apply(query_from_reference, {reference.x_px, reference.y_px}) +
                         0.2 * Vector2d(random.Normal(), random.Normal());
      if (x.x() < 0 || x.y() < 0 || x.x() > kWidth - 1 || x.y() > kHeight - 1) continue;
      const uint8_t* row = plane.descriptors.row(i);
      SeenFeature feature{{static_cast<float>(x.x()), static_cast<float>(x.y()), 8, 0},
                          {row, row + kSiftBytes}};
      for (uint8_t& byte : feature.descriptor) byte = std::max(0, byte + random.Below(9) - 4);
      seen.push_back(feature);
    }
  }
  for (int i = 0; i < clutter; ++i) {
    seen.push_back({{static_cast<float>(random.Uniform(0, kWidth - 1)),
                     static_cast<float>(random.Uniform(0, kHeight - 1)), 8, 0},
                    RandomDescriptor(random)});
  }
  Shuffle(seen, random);
  return Assembled(seen);
}

Features Shuffled(const Features& features, uint64_t seed) {
  std::vector<SeenFeature> seen;
  for (int i = 0; i < features.size(); ++i) {
    const uint8_t* row = features.descriptors.row(i);
    seen.push_back({features.keypoints[i], {row, row + kSiftBytes}});
  }
  Random random(seed);
  Shuffle(seen, random);
  return Assembled(seen);
}

Features FirstFeatures(const Features& features, int count) {
  std::vector<SeenFeature> seen;
  for (int i = 0; i < std::min(count, features.size()); ++i) {
    const uint8_t* row = features.descriptors.row(i);
    seen.push_back({features.keypoints[i], {row, row + kSiftBytes}});
  }
  return Assembled(seen);
}

}  // namespace waystone
