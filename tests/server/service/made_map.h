// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/features/descriptor_codes.h"
#include "core/image/encode.h"
#include "schema/map_data.h"

namespace waystone {

// A small map made by hand: `planes` planes in a chain, seen by two keyframes, of which the first
// has a picture and a time stamp.
inline MapData MadeMap(int planes) {
  MapData map;
  map.info = {"made", "waystone test", FeatureType::kSift, "{}", "sha256:abc123"};
  map.sequences.push_back({SequenceId{1}, "kit\"chen", "folder", 10, 1, std::nullopt});
  map.keyframes.push_back({KeyframeId{1},
                           SequenceId{1},
                           0,
                           0,
                           "rgb/0.jpg",
                           0.5,
                           640,
                           480,
                           {0xFF, 0xD8, 0xFF, 0xD9},
                           {}});
  map.keyframes.push_back({KeyframeId{2}, SequenceId{1}, 0, 7, "rgb/7.jpg", {}, 640, 480, {}, {}});
  for (int i = 1; i <= planes; ++i) {
    Plane plane;
    plane.id = PlaneId{i};
    plane.reference = KeyframeId{1};
    plane.descriptors = Descriptors(DescriptorBytes(FeatureType::kSift));
    for (int f = 0; f < 5; ++f) {
      plane.features.push_back({{10.0F * static_cast<float>(f), 20.0F, 3.0F, 0.1F}, 2, 2});
      const std::vector<uint8_t> row(128, static_cast<uint8_t>(i + f));
      plane.descriptors.Append(row.data());
    }
    plane.outline = {{0, 0}, {100.123, 0}, {100, 50.5}};
    Eigen::Matrix3d shift = Eigen::Matrix3d::Identity();
    shift(0, 2) = 4.25;
    plane.views = {{KeyframeId{1}, Eigen::Matrix3d::Identity(), 5}, {KeyframeId{2}, shift, 5}};
    map.planes.push_back(std::move(plane));
  }
  // Planes 2 and 3 are parts of one surface.
  for (int i = 1; i < planes; ++i) {
    const double third = i == 2 ? 1 : 1.5;
    map.edges.push_back({PlaneId{i}, PlaneId{i + 1}, KeyframeId{1}, KeyframeId{2},
                         Eigen::Vector3d(1, 1, third).asDiagonal(), third});
  }
  return map;
}

// The same with an appearance layer of three nodes on a right angle of 2 units a side, of which the
// first two are keyframes too and a loop joins the ends, and an orientation layer of four frames
// with a turn between two corridors.
inline MapData MadeLayeredMap(int planes, std::optional<double> metres_per_unit = std::nullopt) {
  MapData map = MadeMap(planes);
  AppearanceLayer& appearance = map.appearance.emplace();
  appearance.described = {.rows = 2, .k1 = 3, .k2 = 2, .band = {0.5, -0.25}, .normalise = true};
  appearance.metres_per_unit = metres_per_unit;
  appearance.dropped = 4;
  const Pose2 poses[] = {{0, 0, 0}, {2, 0, 0}, {2, 2, 1.5}};
  for (int i = 0; i < 3; ++i) {
    AppearanceNode node;
    node.id = AppearanceNodeId{i + 1};
    node.sequence = SequenceId{1};
    node.frame = 7 * i;
    node.source = "pano/" + std::to_string(i) + " a.jpg";
    if (i != 1) node.time_s = 0.5 * i;
    node.pose = poses[i];
    node.signature = {HalfMatrix::Constant(2, 3, Eigen::half(0.25F + static_cast<float>(i))),
                      HalfMatrix::Constant(2, 2, Eigen::half(-1.5F))};
    node.features.codes = Descriptors(CodeBytes(map.info.feature_type));
    if (i == 0) node.picture = {0xFF, 0xD8, 0xFF, 0xD9};
    appearance.nodes.push_back(std::move(node));
  }
  const auto edge = [&](int a, int b, AppearanceEdgeKind kind) {
    appearance.edges.push_back({AppearanceNodeId{a}, AppearanceNodeId{b}, kind, 0.25,
                                Inverse(poses[a - 1]) * poses[b - 1], 0.02});
  };
  edge(1, 2, AppearanceEdgeKind::kConsecutive);
  edge(1, 3, AppearanceEdgeKind::kLoop);
  edge(2, 3, AppearanceEdgeKind::kConsecutive);
  OrientationLayer& orientation = map.orientation.emplace();
  orientation.step = 2;
  for (int i = 1; i <= 4; ++i) {
    OrientationFrame frame;
    frame.id = OrientationFrameId{i};
    frame.sequence = SequenceId{1};
    frame.frame = i - 1;
    frame.source = "rgb/" + std::to_string(i - 1) + ".jpg";
    frame.reliable = i < 4;
    if (i < 4) {  // upright; looks along x, from frame 3 on along y
      Eigen::Matrix3d building_from_rig;
      building_from_rig << 0, 0, 1, -1, 0, 0, 0, -1, 0;
      const double heading = i < 3 ? 0 : 1.5707963267948966;
      Eigen::Quaterniond q(Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()) *
                           Eigen::Quaterniond(building_from_rig));
      if (q.w() < 0) q.coeffs() *= -1;
      frame.rotation = BuildingRotation{q, Eigen::Vector3d(1e-4, 1e-4, 4e-4).asDiagonal()};
    }
    frame.lines = {10, 20, 30};
    orientation.frames.push_back(frame);
  }
  orientation.turns = {{OrientationFrameId{3}, 1, 1.5, true, 1}};
  orientation.nodes = {{OrientationFrameId{1}, OrientationNodeKind::kTraversable, {}, {}},
                       {OrientationFrameId{3}, OrientationNodeKind::kTurn, {1, 2, 3, 4}, {}}};
  orientation.nodes[1].picture = {0xFF, 0xD8, 0xFF, 0xD9};
  orientation.edges = {
      {OrientationFrameId{1}, OrientationFrameId{3}, OrientationEdgeKind::kTraversable, 31}};
  orientation.corridors = {{OrientationFrameId{1}, OrientationFrameId{2}, 0},
                           {OrientationFrameId{3}, OrientationFrameId{4}, 1}};
  return map;
}

// Gives a made map of two planes or more poses in metres: both keyframes 1.5 m above the floor
// z = 0, looking along x. Plane 1 is the wall x = 5, plane 2 the floor.
inline void AddMadePoses(MapData& map) {
  PoseLayer& poses = map.poses.emplace();
  poses.frame = "hall";
  poses.unit = LengthUnit::kMetres;
  poses.noise = {0.01, 0};
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  for (const Keyframe& keyframe : map.keyframes) {
    pose.translation() << static_cast<double>(keyframe.id.value), 2, 1.5;
    poses.keyframes.push_back(MakeKeyframePose(keyframe.id, pose));
  }
  poses.planes = {{PlaneId{1}, Eigen::Vector3d::UnitX(), 5, Eigen::Matrix4d::Identity()},
                  {PlaneId{2}, -Eigen::Vector3d::UnitZ(), 0, Eigen::Matrix4d::Identity()}};
}

// Puts a floor plan under a made map with positions: 10 px a unit, (0, 0) at the lower left corner.
inline void AddMadeFloorPlan(MapData& map) {
  FloorPlanImage plan;
  plan.name = "Ground floor";
  plan.width = 80;
  plan.height = 60;
  plan.anchors = {{{0, 60}, {0, 0}}, {{80, 60}, {8, 0}}};
  if (map.poses) plan.heights = PlanHeights{-1, 2.6};
  plan.image = EncodeJpeg(cv::Mat(60, 80, CV_8UC1, cv::Scalar(240)));
  map.floor_plans = {plan};
}

}  // namespace waystone
