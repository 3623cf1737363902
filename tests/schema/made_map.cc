// SPDX-License-Identifier: Apache-2.0
#include "tests/schema/made_map.h"

#include <SQLiteCpp/Database.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "core/base/random.h"
#include "core/features/descriptor_codes.h"
#include "schema/layers/planes/index_features.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

std::string OddName(Random& random) {
  static const std::vector<std::string> kNames = {
      "rgb/000120.jpg",       "K\u00fcche \u2014 \u53a8\u623f/\U0001F4F7.jpg",
      "it's \"quoted\"; --",  "",
      "back\\slash\nnewline", "latin-1 \xe9",
      std::string("a\0b", 3)};
  return kNames[random.Below(static_cast<int>(kNames.size()))];
}

std::vector<uint8_t> RandomBytes(Random& random, int count) {
  std::vector<uint8_t> bytes(count);
  for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random.Below(256));
  return bytes;
}

Eigen::Matrix3d RandomHomography(Random& random) {
  Eigen::Matrix3d h;
  h << random.Uniform(0.7, 1.3), random.Uniform(-0.2, 0.2), random.Uniform(-200, 200),
      random.Uniform(-0.2, 0.2), random.Uniform(0.7, 1.3), random.Uniform(-200, 200),
      random.Uniform(-1e-4, 1e-4), random.Uniform(-1e-4, 1e-4), 1;
  return h;
}

Sequence MadeSequence(Random& random, int64_t id) {
  Sequence sequence{{id}, OddName(random), "folder", random.Below(1000) + 5, random.Below(5), {}};
  if (random.Below(2) == 0) {
    sequence.camera =
        Camera{CameraModel::kPinhole, 640, 480, {random.Uniform(300, 600), 500.5, 319.5, 239.5}};
  } else if (random.Below(2) == 0) {
    sequence.camera = Camera{CameraModel::kEquirectangular, 1024, 512, {}};
  }
  return sequence;
}

// From a generator of its own, so that the rest of a map is the same without any.
Landmarks MadeLandmarks(int64_t seed, const MapShape& shape) {
  Landmarks landmarks;
  if (shape.max_landmarks == 0) return landmarks;
  Random random(seed);
  const int count = random.Below(shape.max_landmarks + 1);
  if (count == 0) return landmarks;
  landmarks.codes = Descriptors(CodeBytes(shape.type));
  for (int i = 0; i < count; ++i) {
    landmarks.positions.push_back(
        {static_cast<uint16_t>(random.Below(65536)), static_cast<uint16_t>(random.Below(65536))});
    landmarks.codes.Append(RandomBytes(random, CodeBytes(shape.type)).data());
  }
  return landmarks;
}

Keyframe MadeKeyframe(Random& random, int64_t id, const MapData& map, const MapShape& shape) {
  Keyframe keyframe;
  keyframe.id = {id};
  keyframe.sequence = map.sequences[random.Below(shape.sequences)].id;
  keyframe.stretch = random.Below(3);
  keyframe.frame = random.Below(1000);
  keyframe.source = OddName(random);
  if (random.Below(2) == 0) keyframe.time_s = random.Uniform(-1, 2e9);
  keyframe.width = 640;
  keyframe.height = 480;
  if (shape.jpeg_bytes > 0 && random.Below(4) > 0) {
    keyframe.picture = RandomBytes(random, random.Below(shape.jpeg_bytes) + 1);
  }
  keyframe.landmarks = MadeLandmarks(id, shape);
  return keyframe;
}

Plane MadePlane(Random& random, int64_t id, const MapData& map, const MapShape& shape) {
  Plane plane;
  plane.id = {id};
  const int reference = random.Below(shape.keyframes);
  plane.reference = map.keyframes[reference].id;
  for (int k = 0; k < shape.keyframes; ++k) {
    if (k != reference && random.Below(2) == 0) continue;
    plane.views.push_back({map.keyframes[k].id, RandomHomography(random), random.Below(500)});
    if (k == reference) plane.views.back().reference_from_keyframe.setIdentity();
  }
  const int features = random.Below(shape.max_features + 1);
  for (int i = 0; i < features; ++i) {
    const Keypoint keypoint{
        static_cast<float>(random.Uniform(-50, 700)), static_cast<float>(random.Uniform(-50, 500)),
        static_cast<float>(random.Uniform(1, 60)), static_cast<float>(random.Uniform(0, 6.28))};
    const int visible = random.Below(60000) + 1;
    plane.features.push_back({keypoint, random.Below(visible) + 1, visible});
  }
  const int bytes = DescriptorBytes(shape.type);
  plane.descriptors = Descriptors(bytes, RandomBytes(random, features * bytes));
  for (int i = random.Below(8); i > 0; --i) {
    plane.outline.emplace_back(random.Uniform(0, 640), random.Uniform(0, 480));
  }
  return plane;
}

Edge MadeEdge(Random& random, const Plane& a, const Plane& b, const MapData& map) {
  // I + v p^T has the eigenvalues 1, 1 and 1 + v^T p.
  const Eigen::Vector3d v(random.Uniform(-40, 40), random.Uniform(-40, 40), random.Uniform(0, 0.1));
  const Eigen::Vector3d p(random.Uniform(0, 1e-3), random.Uniform(0, 1e-3), 1);
  return {a.id,
          b.id,
          map.keyframes[0].id,
          map.keyframes.back().id,
          Eigen::Matrix3d::Identity() + v * p.transpose(),
          1 + v.dot(p)};
}

HalfMatrix RandomHalves(Random& random, int rows, int columns, double low, double high) {
  HalfMatrix matrix(rows, columns);
  for (Eigen::Index i = 0; i < matrix.size(); ++i) {
    matrix.data()[i] = static_cast<Eigen::half>(random.Uniform(low, high));
  }
  return matrix;
}

Pose2 RandomPose(Random& random) {
  return {random.Uniform(-9, 9), random.Uniform(-9, 9), random.Uniform(-3, 3)};
}

AppearanceNode MadeNode(Random& random, int64_t id, const MapData& map,
                        const SignatureOptions& described, const MapShape& shape) {
  AppearanceNode node{{id}, map.sequences[0].id, random.Below(9), OddName(random), {}, {}, {}, {},
                      {}};
  if (random.Below(2) == 0) node.time_s = random.Uniform(0, 9);
  node.pose = RandomPose(random);
  node.signature = {RandomHalves(random, described.rows, described.k1, 0, 200),
                    RandomHalves(random, described.rows, described.k2, -3.1, 3.1)};
  if (shape.jpeg_bytes > 0) node.picture = RandomBytes(random, random.Below(shape.jpeg_bytes));
  const int features = random.Below(4);
  for (int i = 0; i < features; ++i) {
    node.features.bearings.push_back({static_cast<int16_t>(random.Below(65536) - 32768),
                                      static_cast<int16_t>(random.Below(32769) - 16384)});
  }
  const int bytes = CodeBytes(shape.type);
  node.features.codes = Descriptors(bytes, RandomBytes(random, features * bytes));
  return node;
}

AppearanceLayer MadeAppearance(Random& random, const MapData& map, const MapShape& shape) {
  AppearanceLayer layer;
  layer.described = {.rows = 4, .k1 = 5, .k2 = 3, .band = {0.5, -0.25}, .normalise = true};
  if (random.Below(2) == 0) layer.metres_per_unit = random.Uniform(0.1, 2);
  layer.dropped = random.Below(9);
  for (int64_t id = 2; id <= 11; id += 3) {
    layer.nodes.push_back(MadeNode(random, id, map, layer.described, shape));
    if (id == 2) continue;
    const auto kind = static_cast<AppearanceEdgeKind>(random.Below(2));
    layer.edges.push_back({{id - 3}, {id}, kind, random.Uniform(), RandomPose(random), 0.02});
  }
  layer.verdict = AppearanceVerdict{-3.5, {{"distance", -2.0}, {"sharpness", 0.5}}, 12, 30};
  if (random.Below(2) == 0) layer.verified_verdict = AppearanceVerdict{1.5, {{"x", 2.0}}, 1, 0};
  if (random.Below(2) == 0) {
    layer.mirror = LayerMirror{640, 480, 720, {0.5, -0.25}, false, {}};
    if (random.Below(2) == 0) layer.mirror->ring = MirrorRing{{320.5, 239}, 40, 200.25};
  }
  return layer;
}

OrientationLayer MadeOrientation(Random& random, const MapData& map, const MapShape& shape) {
  OrientationLayer layer;
  layer.step = 1 + random.Below(5);
  for (int64_t id = 1; id <= 10; ++id) {
    OrientationFrame frame{
        {id}, map.sequences[0].id, static_cast<int>(id), OddName(random), {}, id % 4 != 0,
        {},   {3, 20, 7}};
    if (id % 2 == 0) frame.time_s = random.Uniform(0, 9);
    if (id % 8 != 0) {
      const Eigen::Quaterniond q(
          Eigen::AngleAxisd(random.Uniform(0, 3), Eigen::Vector3d(0.6, 0, 0.8)));
      frame.rotation = BuildingRotation{q, Eigen::Vector3d(1e-4, 2e-4, 0).asDiagonal()};
    }
    layer.frames.push_back(frame);
  }
  layer.turns = {{{3}, 1, 1.46, true, 1}, {{6}, -1, -1.53, false, 1}};
  layer.nodes = {{{3}, OrientationNodeKind::kTurn, {1, 2, 3, 4}, {}},
                 {{5}, OrientationNodeKind::kTraversable, {0, 0, 0, 9}, {}},
                 {{10}, OrientationNodeKind::kTraversable, {}, {}}};
  if (shape.jpeg_bytes > 0) layer.nodes[1].picture = RandomBytes(random, shape.jpeg_bytes);
  layer.edges = {{{3}, {5}, OrientationEdgeKind::kTraversable, 31},
                 {{3}, {10}, OrientationEdgeKind::kLoop, 46}};
  layer.corridors = {{{1}, {2}, 0}, {{4}, {9}, 1}};
  return layer;
}

// Of the first keyframe and of what it has, and of one more.
PoseLayer MadePoses(Random& random, const MapData& map) {
  PoseLayer layer;
  layer.frame = OddName(random);
  layer.unit = LengthUnit::kMetres;
  layer.noise = {random.Uniform(), random.Uniform()};
  const auto depths = [&](size_t count) {
    std::vector<DepthCode> codes(count);
    for (DepthCode& code : codes) {
      if (random.Below(4) > 0) code = EncodeDepth(random.Uniform(0.1, 100), random.Uniform());
    }
    return codes;
  };
  for (const Keyframe& keyframe : map.keyframes) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() = Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal());
    pose.linear() =
        Eigen::AngleAxisd(random.Uniform(-3, 3), Eigen::Vector3d(1, 2, 3).normalized()).matrix();
    layer.keyframes.push_back(MakeKeyframePose(keyframe.id, pose));
    if (keyframe.landmarks.size() == 0) continue;
    layer.landmark_depths.push_back({keyframe.id, depths(keyframe.landmarks.size())});
  }
  for (const Plane& plane : map.planes) {
    if (plane.features.empty()) continue;
    layer.plane_depths.push_back({plane.id, depths(plane.features.size())});
    const Eigen::Vector4d spread(random.Normal(), random.Normal(), random.Normal(), 1);
    layer.planes.push_back(
        {plane.id, Eigen::Vector3d(1, 2, -2) / 3, random.Normal(), spread * spread.transpose()});
  }
  return layer;
}

}  // namespace

MapData MadeMap(uint64_t seed, const MapShape& shape) {
  Random random(seed);
  MapData map;
  map.info = {OddName(random), "waystone test", shape.type,
              "{\"seed\":" + std::to_string(seed) + "}", ""};
  int64_t id = 0;
  for (int i = 0; i < shape.sequences; ++i) {
    map.sequences.push_back(MadeSequence(random, id += 1 + random.Below(3)));
  }
  id = 0;
  for (int i = 0; i < shape.keyframes; ++i) {
    map.keyframes.push_back(MadeKeyframe(random, id += 1 + random.Below(3), map, shape));
  }
  id = 0;
  for (int i = 0; i < shape.planes; ++i) {
    map.planes.push_back(MadePlane(random, id += 1 + random.Below(3), map, shape));
  }
  for (int i = 0; i < shape.planes; ++i) {
    for (int k = i + 1; k < shape.planes; ++k) {
      if (random.Below(2) == 0) continue;
      map.edges.push_back(MadeEdge(random, map.planes[i], map.planes[k], map));
    }
  }
  map.index = IndexFeatures(map, {.min_rows = 1});
  map.verdict = VerdictModel{-12.5, 5.25, 2.75, 60, 120};
  map.appearance = MadeAppearance(random, map, shape);
  map.orientation = MadeOrientation(random, map, shape);
  map.poses = MadePoses(random, map);
  return map;
}

TemporaryFolder::TemporaryFolder() {
  std::string name = (fs::temp_directory_path() / "waystone_schema_XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code error;
  fs::remove_all(path_, error);
}

std::vector<std::string> TemporaryFolder::Names() const {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(path_)) {
    names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::string ReadFile(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  EXPECT_TRUE(in) << path;
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void WriteFile(const fs::path& path, const std::string& bytes) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out << bytes;
  ASSERT_TRUE(out.flush()) << path;
}

void RunSql(const fs::path& path, const std::string& sql) {
  SQLite::Database database(path.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
  database.exec(
      "PRAGMA foreign_keys = OFF; PRAGMA ignore_check_constraints = ON; PRAGMA synchronous = OFF;");
  database.exec(sql);
}

MapData WithoutVersion(MapData map) {
  map.info.version.clear();
  return map;
}

MapError ErrorOf(const std::function<void()>& run) {
  try {
    run();
  } catch (const MapError& error) {
    return error;
  }
  ADD_FAILURE() << "nothing was thrown";
  return {ErrorCode::kInternal, ""};
}

}  // namespace waystone
