// SPDX-License-Identifier: Apache-2.0
#include "schema/file/map_problems.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/schema/made_map.h"

namespace waystone {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

struct Fault {
  const char* name;
  std::string where;  // what the problem's place starts with
  std::function<void(MapData&)> make;
};

// Ids of the map that the faults are made in: sequences 1, 2; keyframes 1 to 3; planes 1, 2.
MapData SmallMap() {
  MapData map;
  map.sequences = {{{1}, "a", "folder", 10, 1, Camera{CameraModel::kPinhole, 64, 48, {9, 9, 3, 2}}},
                   {{2}, "b", "video", 10, 0, {}}};
  for (int64_t id = 1; id <= 3; ++id) {
    map.keyframes.push_back({{id}, {1}, 0, 0, "x", 1.5, 640, 480, {1, 2, 3}, {}});
  }
  for (int64_t id = 1; id <= 2; ++id) {
    Plane plane;
    plane.id = {id};
    plane.reference = {2};
    plane.features = {{{1, 2, 3, 0}, 2, 2}, {{4, 5, 6, 1}, 1, 3}};
    plane.descriptors = Descriptors(128, std::vector<uint8_t>(256, 5));
    plane.outline = {{0, 0}, {1, 0}, {0, 1}};
    plane.views = {{{1}, Eigen::Matrix3d::Identity() * 1.25, 5},
                   {{2}, Eigen::Matrix3d::Identity(), 5}};
    map.planes.push_back(plane);
  }
  const Eigen::Vector3d v(30, -20, 0.02);
  const Eigen::Vector3d p(1e-3, 2e-3, 1);
  map.edges = {{{1}, {2}, {1}, {2}, Eigen::Matrix3d::Identity() + v * p.transpose(), 1 + v.dot(p)}};
  return map;
}

constexpr Eigen::half kHalfNan = Eigen::NumTraits<Eigen::half>::quiet_NaN();

// The same with three panoramas and three frames of the orientation layer.
MapData LayeredMap() {
  MapData map = SmallMap();
  map.appearance.emplace();
  map.appearance->described = {.rows = 2, .k1 = 3, .k2 = 2, .band = {}, .normalise = false};
  for (int64_t id = 1; id <= 3; ++id) {
    AppearanceNode node;
    node.id = {id};
    node.sequence = {1};
    node.signature = {HalfMatrix::Ones(2, 3), HalfMatrix::Zero(2, 2)};
    node.features = {{{500, 100}}, Descriptors(32, std::vector<uint8_t>(32, 5))};
    map.appearance->nodes.push_back(node);
  }
  map.appearance->edges = {{{1}, {2}, AppearanceEdgeKind::kConsecutive, 0.1, {1, 0, 0}, 0.01},
                           {{1}, {3}, AppearanceEdgeKind::kLoop, 0.1, {1, 0, 0}, 0.01}};
  map.appearance->verdict = AppearanceVerdict{-1, {{"a", 1.0}, {"b", 2.0}}, 1, 1};
  map.orientation.emplace();
  for (int64_t id = 1; id <= 3; ++id) {
    map.orientation->frames.push_back(
        {{id}, {1}, static_cast<int>(id), "x", {}, true, BuildingRotation{}, {1, 2, 3}});
  }
  map.orientation->turns = {{{2}, 1, 1.5, true, 0}, {{3}, -1, -1.5, false, 0}};
  map.orientation->nodes = {{{1}, OrientationNodeKind::kTraversable, {}, {}},
                            {{2}, OrientationNodeKind::kTurn, {}, {}}};
  map.orientation->edges = {{{1}, {2}, OrientationEdgeKind::kTraversable, 10}};
  map.orientation->corridors = {{{1}, {2}, 0}};
  map.keyframes[0].landmarks = {{{1, 2}, {3, 4}}, Descriptors(32, std::vector<uint8_t>(64, 5))};
  map.poses.emplace();
  map.poses->frame = "hall";
  const Eigen::Isometry3d pose(Eigen::Translation3d(1, 2, 3));
  map.poses->keyframes = {MakeKeyframePose({1}, pose), MakeKeyframePose({2}, pose)};
  map.poses->planes = {{{1}, {0, 0, 1}, 2, Eigen::Matrix4d::Identity()}};
  map.poses->plane_depths = {{{1}, {EncodeDepth(2, 0.1), {}}}};
  map.poses->landmark_depths = {{{1}, {EncodeDepth(2, 0.1), {}}}};
  return map;
}

const std::vector<Fault>& AppearanceFaults() {
  static const std::vector<Fault> faults = {
      {"no rows", "appearance_layer 1", [](MapData& m) { m.appearance->described.rows = 0; }},
      {"empty band", "appearance_layer 1",
       [](MapData& m) {
         m.appearance->described.band = {-1, 1};
       }},
      {"no scale", "appearance_layer 1", [](MapData& m) { m.appearance->metres_per_unit = 0; }},
      {"dropped below 0", "appearance_layer 1", [](MapData& m) { m.appearance->dropped = -1; }},
      {"id twice", "appearance_nodes 2", [](MapData& m) { m.appearance->nodes[2].id = {2}; }},
      {"no such sequence", "appearance_nodes 1",
       [](MapData& m) { m.appearance->nodes[0].sequence = {9}; }},
      {"time NaN", "appearance_nodes 1", [](MapData& m) { m.appearance->nodes[0].time_s = kNan; }},
      {"pose NaN", "appearance_nodes 1", [](MapData& m) { m.appearance->nodes[0].pose.x = kNan; }},
      {"angle not wrapped", "appearance_nodes 1",
       [](MapData& m) { m.appearance->nodes[0].pose.theta_rad = 4; }},
      {"magnitudes missing", "appearance_signatures 1",
       [](MapData& m) { m.appearance->nodes[0].signature.magnitudes.resize(2, 2); }},
      {"magnitude below 0", "appearance_signatures 1",
       [](MapData& m) { m.appearance->nodes[0].signature.magnitudes(0, 1) = Eigen::half(-1); }},
      {"magnitude NaN", "appearance_signatures 1",
       [](MapData& m) { m.appearance->nodes[0].signature.magnitudes(0, 1) = kHalfNan; }},
      {"phase out of range", "appearance_signatures 1",
       [](MapData& m) { m.appearance->nodes[0].signature.phases(1, 1) = Eigen::half(3.2); }},
      {"codes missing", "appearance_features 1",
       [](MapData& m) { m.appearance->nodes[0].features.codes = {}; }},
      {"codes of another kind", "appearance_features 1",
       [](MapData& m) {
         m.appearance->nodes[0].features.codes = Descriptors(61, std::vector<uint8_t>(61));
       }},
      {"bearing under the floor", "appearance_features 1",
       [](MapData& m) { m.appearance->nodes[0].features.bearings[0].elevation = -16385; }},
      {"edge backwards", "appearance_edges 2/1",
       [](MapData& m) { std::swap(m.appearance->edges[0].a, m.appearance->edges[0].b); }},
      {"edge twice", "appearance_edges 1/2", [](MapData& m) { m.appearance->edges[1].b = {2}; }},
      {"edge to no node", "appearance_edges 1/7",
       [](MapData& m) { m.appearance->edges[1].b = {7}; }},
      {"distance below 0", "appearance_edges 1/2",
       [](MapData& m) { m.appearance->edges[0].distance = -1; }},
      {"heading NaN", "appearance_edges 1/2",
       [](MapData& m) { m.appearance->edges[0].a_from_b.theta_rad = kNan; }},
      {"deviation below 0", "appearance_edges 1/2",
       [](MapData& m) { m.appearance->edges[0].sigma_rad = -0.1; }},
      {"term twice", "appearance_verdict 1",
       [](MapData& m) { m.appearance->verdict->terms[1].name = "a"; }},
      {"weight NaN", "appearance_verdict 1",
       [](MapData& m) { m.appearance->verdict->terms[1].weight = kNan; }},
      {"fewer than 0 samples", "appearance_verdict 2",
       [](MapData& m) {
         m.appearance->verified_verdict = AppearanceVerdict{0, {}, -1, 0};
       }},
  };
  return faults;
}

const std::vector<Fault>& OrientationFaults() {
  static const std::vector<Fault> faults = {
      {"no step", "orientation_layer 1", [](MapData& m) { m.orientation->step = 0; }},
      {"id twice", "orientation_frames 2", [](MapData& m) { m.orientation->frames[2].id = {2}; }},
      {"no such sequence", "orientation_frames 1",
       [](MapData& m) { m.orientation->frames[0].sequence = {9}; }},
      {"frames out of order", "orientation_frames 2",
       [](MapData& m) { m.orientation->frames[1].frame = 1; }},
      {"lines below 0", "orientation_frames 1",
       [](MapData& m) { m.orientation->frames[0].lines[2] = -1; }},
      {"reliable without a rotation", "orientation_frames 1",
       [](MapData& m) { m.orientation->frames[0].rotation.reset(); }},
      {"quaternion of another norm", "orientation_frames 1",
       [](MapData& m) { m.orientation->frames[0].rotation->building_from_rig.x() = 0.1; }},
      {"covariance below 0", "orientation_frames 1",
       [](MapData& m) { m.orientation->frames[0].rotation->covariance(1, 1) = -1; }},
      {"covariance not symmetric", "orientation_frames 1",
       [](MapData& m) { m.orientation->frames[0].rotation->covariance(0, 1) = 1e-3; }},
      {"turn of no frame", "orientation_turns 8",
       [](MapData& m) { m.orientation->turns[1].frame = {8}; }},
      {"turn without a direction", "orientation_turns 3",
       [](MapData& m) { m.orientation->turns[1].direction = 0; }},
      {"turn by too much", "orientation_turns 3",
       [](MapData& m) { m.orientation->turns[1].angle_rad = 3.2; }},
      {"turn without a node", "orientation_turns 3",
       [](MapData& m) { m.orientation->turns[1].confirmed = true; }},
      {"node of another kind", "orientation_nodes 1",
       [](MapData& m) { m.orientation->nodes[0].kind = OrientationNodeKind::kTurn; }},
      {"directions below 0", "orientation_nodes 1",
       [](MapData& m) { m.orientation->nodes[0].directions[3] = -1; }},
      {"edge to no node", "orientation_edges 1/3",
       [](MapData& m) { m.orientation->edges[0].b = {3}; }},
      {"edge to itself", "orientation_edges 1/1",
       [](MapData& m) { m.orientation->edges[0].b = {1}; }},
      {"corridor backwards", "corridors 2",
       [](MapData& m) {
         m.orientation->corridors[0] = {{2}, {1}, 0};
       }},
      {"corridor without an end", "corridors 1",
       [](MapData& m) { m.orientation->corridors[0].last = {8}; }},
      {"corridors that overlap", "corridors 2",
       [](MapData& m) {
         m.orientation->corridors.push_back({{2}, {3}, 1});
       }},
      {"corridor along z", "corridors 1", [](MapData& m) { m.orientation->corridors[0].axis = 2; }},
  };
  return faults;
}

const std::vector<Fault>& Faults() {
  static const std::vector<Fault> faults = {
      {"repeated id", "keyframes 2", [](MapData& m) { m.keyframes[2].id = {2}; }},
      {"id 0", "sequences 0", [](MapData& m) { m.sequences[0].id = {0}; }},
      {"planes out of order", "planes 1", [](MapData& m) { std::swap(m.planes[0], m.planes[1]); }},
      {"more skipped than read", "sequences 2", [](MapData& m) { m.sequences[1].skipped = 11; }},
      {"camera with a short list", "sequences 1",
       [](MapData& m) { m.sequences[0].camera->params.pop_back(); }},
      {"camera with NaN", "sequences 1",
       [](MapData& m) { m.sequences[0].camera->params[2] = kNan; }},
      {"sequence that isn't there", "keyframes 1",
       [](MapData& m) { m.keyframes[0].sequence = {7}; }},
      {"frame below 0", "keyframes 1", [](MapData& m) { m.keyframes[0].frame = -1; }},
      {"no pixels", "keyframes 1", [](MapData& m) { m.keyframes[0].width = 0; }},
      {"time NaN", "keyframes 1", [](MapData& m) { m.keyframes[0].time_s = kNan; }},
      {"reference that isn't there", "planes 1", [](MapData& m) { m.planes[0].reference = {9}; }},
      {"no view of the reference", "planes 2", [](MapData& m) { m.planes[1].views.pop_back(); }},
      {"reference's view isn't the identity", "plane_views 1/2",
       [](MapData& m) { m.planes[0].views[1].reference_from_keyframe(0, 2) = 1; }},
      {"view of no keyframe", "plane_views 1/5",
       [](MapData& m) {
         m.planes[0].views.push_back({{5}, Eigen::Matrix3d::Identity(), 1});
       }},
      {"view twice", "plane_views 1/2",
       [](MapData& m) { m.planes[0].views.push_back(m.planes[0].views[1]); }},
      {"inliers below 0", "plane_views 1/1", [](MapData& m) { m.planes[0].views[0].inliers = -1; }},
      {"homography with NaN", "plane_views 1/1",
       [](MapData& m) { m.planes[0].views[0].reference_from_keyframe(2, 1) = kNan; }},
      {"homography of rank 2", "plane_views 1/1",
       [](MapData& m) { m.planes[0].views[0].reference_from_keyframe(0, 0) = 0; }},
      {"homography that is nearly of rank 2", "plane_views 1/1",
       [](MapData& m) { m.planes[0].views[0].reference_from_keyframe(0, 0) = 1e-9; }},
      {"homography of zeros", "plane_views 1/1",
       [](MapData& m) { m.planes[0].views[0].reference_from_keyframe.setZero(); }},
      {"feature NaN", "plane_features 1",
       [](MapData& m) { m.planes[0].features[1].reference.angle_rad = NAN; }},
      {"feature without votes", "plane_features 1",
       [](MapData& m) { m.planes[0].features[0].votes = 0; }},
      {"far more votes than views", "plane_features 1",
       [](MapData& m) { m.planes[0].features[0].votes = 5; }},
      {"more votes than fit", "plane_features 1",
       [](MapData& m) { m.planes[0].features[0].votes = m.planes[0].features[0].visible = 65536; }},
      {"descriptors missing", "plane_features 1",
       [](MapData& m) { m.planes[0].descriptors = Descriptors(128); }},
      {"codes without landmarks", "keyframe_landmarks 1",
       [](MapData& m) {
         m.keyframes[0].landmarks.codes = Descriptors(32, {std::vector<uint8_t>(32)});
       }},
      {"landmark codes of another kind", "keyframe_landmarks 1",
       [](MapData& m) {
         m.keyframes[0].landmarks = {{{1, 2}}, Descriptors(61, std::vector<uint8_t>(61))};
       }},
      {"descriptors of another kind", "plane_features 1",
       [](MapData& m) { m.info.feature_type = FeatureType::kOrb; }},
      {"outline infinite", "planes 1", [](MapData& m) { m.planes[0].outline[0].x() = INFINITY; }},
      {"edge backwards", "edges 2/1", [](MapData& m) { std::swap(m.edges[0].a, m.edges[0].b); }},
      {"edge to itself", "edges 1/1", [](MapData& m) { m.edges[0].b = {1}; }},
      {"edge twice", "edges 1/2", [](MapData& m) { m.edges.push_back(m.edges[0]); }},
      {"edge to no plane", "edges 1/3", [](MapData& m) { m.edges[0].b = {3}; }},
      {"edge from no keyframe", "edges 1/2", [](MapData& m) { m.edges[0].from = {4}; }},
      {"homology infinite", "edges 1/2", [](MapData& m) { m.edges[0].homology(1, 1) = INFINITY; }},
      {"homology scaled", "edges 1/2", [](MapData& m) { m.edges[0].homology *= 1.01; }},
      {"another third eigenvalue", "edges 1/2",
       [](MapData& m) { m.edges[0].third_eigenvalue += 0.01; }},
      {"third eigenvalue NaN", "edges 1/2", [](MapData& m) { m.edges[0].third_eigenvalue = kNan; }},
  };
  return faults;
}

TEST(MapProblems, ASoundMapHasNone) {
  EXPECT_TRUE(FindMapProblems(SmallMap()).empty());
  EXPECT_TRUE(FindMapProblems(LayeredMap()).empty());
  EXPECT_TRUE(FindMapProblems({}).empty());
  for (uint64_t seed = 0; seed < 50; ++seed) {
    for (const MapProblem& problem : FindMapProblems(MadeMap(seed))) {
      ADD_FAILURE() << "seed " << seed << ": " << problem.where << ": " << problem.message;
    }
  }
}

const std::vector<Fault>& PoseFaults() {
  static const std::vector<Fault> faults = {
      {"position sigma below 0", "pose_layer 1",
       [](MapData& m) { m.poses->noise.position_sigma = -1; }},
      {"rotation sigma NaN", "pose_layer 1",
       [](MapData& m) { m.poses->noise.rotation_sigma_rad = kNan; }},
      {"pose of no keyframe", "keyframe_poses 9",
       [](MapData& m) { m.poses->keyframes[1].keyframe = {9}; }},
      {"pose twice", "keyframe_poses 1", [](MapData& m) { m.poses->keyframes[1].keyframe = {1}; }},
      {"quaternion of another norm", "keyframe_poses 1",
       [](MapData& m) { m.poses->keyframes[0].rotation.x() = 0.1; }},
      {"position not finite", "keyframe_poses 2",
       [](MapData& m) { m.poses->keyframes[1].position.y() = kNan; }},
      {"pose of no plane", "plane_poses 9", [](MapData& m) { m.poses->planes[0].plane = {9}; }},
      {"normal of another length", "plane_poses 1",
       [](MapData& m) { m.poses->planes[0].normal *= 2; }},
      {"distance not finite", "plane_poses 1",
       [](MapData& m) { m.poses->planes[0].distance = kNan; }},
      {"plane covariance not finite", "plane_poses 1",
       [](MapData& m) { m.poses->planes[0].covariance(1, 2) = kNan; }},
      {"depths of no plane", "plane_depths 9",
       [](MapData& m) { m.poses->plane_depths[0].plane = {9}; }},
      {"too few depths", "plane_depths 1",
       [](MapData& m) { m.poses->plane_depths[0].features.pop_back(); }},
      {"depths without a pose", "plane_depths 1",
       [](MapData& m) { m.poses->keyframes.pop_back(); }},
      {"depths of no keyframe", "landmark_depths 9",
       [](MapData& m) { m.poses->landmark_depths[0].keyframe = {9}; }},
      {"too many depths", "landmark_depths 1",
       [](MapData& m) { m.poses->landmark_depths[0].landmarks.push_back({}); }}};
  return faults;
}

TEST(MapProblems, EveryFaultIsFoundWhereItIs) {
  std::vector<Fault> faults = Faults();
  for (const auto* more : {&AppearanceFaults(), &OrientationFaults(), &PoseFaults()}) {
    faults.insert(faults.end(), more->begin(), more->end());
  }
  for (const Fault& fault : faults) {
    MapData map = LayeredMap();
    fault.make(map);
    const std::vector<MapProblem> problems = FindMapProblems(map);
    bool found = false;
    for (const MapProblem& problem : problems) {
      found |= problem.where == fault.where;
      EXPECT_FALSE(problem.message.empty());
    }
    EXPECT_TRUE(found) << fault.name << (problems.empty() ? "" : ": " + problems[0].where);
  }
}

TEST(MapProblems, AllAreListed) {
  MapData map = SmallMap();
  map.keyframes[0].width = 0;
  map.planes[0].features[0].votes = 0;
  map.edges[0].third_eigenvalue = 3;
  EXPECT_EQ(FindMapProblems(map).size(), 3u);
}

// A measured homology's double eigenvalue is a pair, real or complex, with 1 as its mean.
TEST(MapProblems, AMeasuredHomologyIsSound) {
  MapData map = SmallMap();
  Edge& edge = map.edges[0];
  for (const double split : {0.05, -0.05}) {
    edge.homology << 1, split, 0, std::abs(split), 1, 0, 0, 0, 1.5;
    edge.third_eigenvalue = 1.5;
    EXPECT_TRUE(FindMapProblems(map).empty());
    // As fusion turns an edge round.
    edge.homology = edge.homology.inverse().eval();
    edge.third_eigenvalue = 1 / 1.5;
    EXPECT_TRUE(FindMapProblems(map).empty());
  }
}

}  // namespace
}  // namespace waystone
