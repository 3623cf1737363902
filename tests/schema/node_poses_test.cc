// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "schema/file/map_problems.h"
#include "schema/file/map_store.h"
#include "schema/layers/poses/horizontal.h"
#include "tests/schema/made_map.h"

namespace waystone {
namespace {

// All nodes but the last have poses, of which the layer has what is seen from above.
MapData MapWithNodePoses() {
  MapData map = MadeMap(5);
  std::vector<AppearanceNode>& nodes = map.appearance->nodes;
  for (size_t i = 0; i + 1 < nodes.size(); ++i) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    const double turn = 0.7 * static_cast<double>(i);
    pose.linear() << std::sin(turn), 0, std::cos(turn), -std::cos(turn), 0, std::sin(turn), 0, -1,
        0;
    pose.translation() = Eigen::Vector3d(1.5 * static_cast<double>(i), -2, 1.6);
    map.poses->nodes.push_back(MakeNodePose(nodes[i].id, pose));
  }
  map.poses->verified_errors = NodePoseErrors{.position_factor = 0.7,
                                              .height_sigma = 0.02,
                                              .heading_sigma_rad = 0.003,
                                              .tilt_sigma_rad = 0.004};
  const Horizontal horizontal = HorizontalOf(*map.poses);
  for (size_t i = 0; i + 1 < nodes.size(); ++i) nodes[i].pose = horizontal.Of(map.poses->nodes[i]);
  return map;
}

std::string ProblemAfter(const std::function<void(MapData&)>& change) {
  MapData map = MapWithNodePoses();
  change(map);
  const std::vector<MapProblem> problems = FindMapProblems(map);
  return problems.empty() ? "" : problems[0].where + ": " + problems[0].message;
}

TEST(NodePoses, AreReadAsTheyWereWritten) {
  const TemporaryFolder folder;
  const MapData map = MapWithNodePoses();
  ASSERT_GE(map.poses->nodes.size(), 2u);
  WriteMap(map, folder / "m.db", {});
  EXPECT_TRUE(CheckMap(folder / "m.db").empty());
  const MapData read = ReadMap(folder / "m.db");
  EXPECT_EQ(read.poses, map.poses);
  EXPECT_FALSE(read.poses->appearance_errors);
  EXPECT_EQ(read.poses->Find(map.appearance->nodes.back().id), nullptr);
}

TEST(NodePoses, MapsWithoutThemHaveNoTable) {
  const TemporaryFolder folder;
  WriteMap(MadeMap(5), folder / "m.db", {});
  EXPECT_EQ(ReadFile(folder / "m.db").find("node_pose"), std::string::npos);
}

// Names are written into other optional tables of the same file.
TEST(NodePoses, StayWhereNamesAreWritten) {
  const TemporaryFolder folder;
  WriteMap(MapWithNodePoses(), folder / "m.db", {});
  MapData named = ReadMap(folder / "m.db");
  named.names = {{"all",
                  {{NamedKind::kNodes, named.appearance->nodes[0].id.value,
                    named.appearance->nodes[1].id.value}},
                  {}}};
  RewriteOptionalTables(named, folder / "m.db");
  const MapData read = ReadMap(folder / "m.db");
  EXPECT_EQ(read.names, named.names);
  EXPECT_EQ(read.poses, named.poses);
}

TEST(NodePoses, ThatBreakARuleAreFound) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(ProblemAfter([](MapData&) {}), "");
  const auto expect = [](const std::string& part, const std::function<void(MapData&)>& change) {
    const std::string problem = ProblemAfter(change);
    EXPECT_NE(problem.find(part), std::string::npos) << problem;
  };
  expect("node_poses 999: no such node", [](MapData& m) { m.poses->nodes.back().node = {999}; });
  expect("increasing", [](MapData& m) { m.poses->nodes[1].node = m.poses->nodes[0].node; });
  expect("its quaternion", [](MapData& m) { m.poses->nodes[0].rotation.coeffs() *= 1.01; });
  expect("seen from above", [](MapData& m) { m.poses->nodes[0].position.x() += 0.01; });
  expect("seen from above", [](MapData& m) { m.appearance->nodes[1].pose.theta_rad -= 0.01; });
  expect("no such node", [](MapData& m) { m.appearance.reset(); });
  expect("node_pose_errors 2", [](MapData& m) { m.poses->verified_errors->tilt_sigma_rad = -1; });
  expect("node_pose_errors 1", [](MapData& m) {
    m.poses->appearance_errors = NodePoseErrors{.position_factor = kInfinity,
                                                .height_sigma = 0,
                                                .heading_sigma_rad = 0,
                                                .tilt_sigma_rad = 0};
  });
}

// The rows say nothing without the frame that they are in.
TEST(NodePoses, WithoutTheirLayerAreADamage) {
  const TemporaryFolder folder;
  WriteMap(MapWithNodePoses(), folder / "m.db", {});
  RunSql(folder / "m.db",
         "PRAGMA foreign_keys=OFF; DELETE FROM pose_layer; DELETE FROM keyframe_poses; DELETE FROM "
         "plane_poses; DELETE FROM plane_depths; DELETE FROM landmark_depths");
  bool found = false;
  for (const MapProblem& problem : CheckMap(folder / "m.db")) {
    found |= problem.message.find("no pose_layer") != std::string::npos;
  }
  EXPECT_TRUE(found);
}

// Up is the mean of the tops of all images, also where there are no keyframes.
TEST(NodePoses, SayWhatIsUp) {
  PoseLayer layer;
  EXPECT_FALSE(EstimateUp(layer));
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  // a camera's y is down
  layer.nodes.push_back(MakeNodePose({1}, pose));
  ASSERT_TRUE(EstimateUp(layer));
  EXPECT_TRUE(EstimateUp(layer)->isApprox(-Eigen::Vector3d::UnitY()));
  const Horizontal horizontal = HorizontalOf(layer);
  const Pose2 above = horizontal.Of(layer.nodes[0]);
  EXPECT_NEAR(above.theta_rad, std::atan2(horizontal.top.z(), horizontal.right.z()), 1e-12);
}

}  // namespace
}  // namespace waystone
