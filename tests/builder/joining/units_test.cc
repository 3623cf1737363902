// SPDX-License-Identifier: Apache-2.0
// Maps of very different units: one in metres, one in millimetres that nobody calls so.
#include <gtest/gtest.h>

#include <cmath>

#include "builder/joining/join_appearance.h"
#include "builder/joining/join_frames.h"

namespace waystone {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr int kCount = 8;
constexpr double kUnits = 1000;  // of the second map in a metre
constexpr double kSigma = 20;    // of its answers, in its unit

// Along a bent walk, in metres.
Isometry3d PoseAlong(int i) {
  Isometry3d pose = Isometry3d::Identity();
  pose.translation() = Vector3d(i, 0.1 * i * i, 0.2 * (i % 3));
  return pose;
}

Isometry3d InSecond(Isometry3d pose) {
  pose.translation() *= kUnits;
  return pose;
}

// The second map was asked for keyframes of the first, whose frame is kept.
TEST(JoinedUnits, FramesAlignByWhatTheMapThatChangesAnswered) {
  std::vector<MapData> maps(2);
  maps[0].poses.emplace().unit = LengthUnit::kMetres;
  maps[1].poses.emplace();
  Recognition recognition{.asked = 1, .asking = 0, .keyframes = {}};
  for (int i = 0; i < kCount; ++i) {
    const KeyframeId id{i + 1};
    for (MapData& map : maps) map.keyframes.emplace_back().id = id;
    maps[0].poses->keyframes.push_back(MakeKeyframePose(id, PoseAlong(i)));
    maps[1].poses->keyframes.push_back(MakeKeyframePose(id, InSecond(PoseAlong(i))));
    QueryPose answered;
    answered.frame_from_camera = InSecond(PoseAlong(i));
    answered.frame_from_camera.translation() += Vector3d(i % 2, -i % 3, 1) * 0.5 * kSigma;
    answered.covariance.topLeftCorner<3, 3>().diagonal().setConstant(kSigma * kSigma);
    const auto at = static_cast<size_t>(i);
    recognition.keyframes.push_back({.asking = at, .found = at, .pose = answered});
  }
  std::vector<Recognition> recognitions{recognition};
  EXPECT_EQ(JoinFrames(recognitions, false, maps), 0U);
  EXPECT_EQ(maps[1].poses->unit, LengthUnit::kMetres);
  for (int i = 0; i < kCount; ++i) {
    const Vector3d& at = maps[1].poses->keyframes[i].position;
    EXPECT_LT((at - PoseAlong(i).translation()).norm(), 0.1) << i;
  }
}

TEST(JoinedUnits, LayersAlignByWhatTheMapThatChangesAnswered) {
  std::vector<MapData> maps(2);
  Recognition recognition{.asked = 1, .asking = 0, .keyframes = {}};
  for (size_t m = 0; m < maps.size(); ++m) {
    AppearanceLayer& layer = maps[m].appearance.emplace();
    const double unit = m == 0 ? 1 : kUnits;
    for (int i = 0; i < kCount; ++i) {
      AppearanceNode& node = layer.nodes.emplace_back();
      node.id = AppearanceNodeId{i + 1};
      node.pose = {unit * i, 0.1 * unit * i * i, 0.1 * i};
      node.signature.magnitudes = HalfMatrix::Zero(layer.described.rows, layer.described.k1);
      node.signature.phases = HalfMatrix::Zero(layer.described.rows, layer.described.k2);
      if (i == 0) continue;
      AppearanceEdge& edge = layer.edges.emplace_back();
      edge.a = layer.nodes[i - 1].id;
      edge.b = node.id;
      edge.a_from_b = Inverse(layer.nodes[i - 1].pose) * node.pose;
    }
  }
  for (size_t i = 0; i < kCount; ++i) {
    RecognisedNode& one = recognition.nodes.emplace_back();
    one.asking = one.found = one.best = i;
    one.pose = maps[1].appearance->nodes[i].pose;
    one.position_sigma = kSigma;
    one.heading_sigma_rad = 0.02;
  }
  EXPECT_EQ(JoinAppearance({recognition}, {}, maps).size(), static_cast<size_t>(kCount));
  for (int i = 0; i < kCount; ++i) {
    const Pose2& a = maps[0].appearance->nodes[i].pose;
    const Pose2& b = maps[1].appearance->nodes[i].pose;
    EXPECT_LT(std::hypot(a.x - b.x, a.y - b.y), 0.1) << i;
  }
}

}  // namespace
}  // namespace waystone
