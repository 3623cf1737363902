// SPDX-License-Identifier: Apache-2.0
#include "schema/map_problems.h"

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
    map.keyframes.push_back({{id}, {1}, 0, 0, "x", 1.5, 640, 480, {1, 2, 3}});
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
  EXPECT_TRUE(FindMapProblems({}).empty());
  for (uint64_t seed = 0; seed < 50; ++seed) {
    for (const MapProblem& problem : FindMapProblems(MadeMap(seed))) {
      ADD_FAILURE() << "seed " << seed << ": " << problem.where << ": " << problem.message;
    }
  }
}

TEST(MapProblems, EveryFaultIsFoundWhereItIs) {
  for (const Fault& fault : Faults()) {
    MapData map = SmallMap();
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
