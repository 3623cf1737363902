// SPDX-License-Identifier: Apache-2.0
#include "schema/layers/orientation/orientation_trajectory.h"

#include <gtest/gtest.h>

#include <cmath>

namespace waystone {
namespace {

OrientationFrame FrameAt(int64_t id, int64_t sequence, int frame, double heading_rad) {
  Eigen::Matrix3d upright;  // looks along the building's x
  upright << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const Eigen::Quaterniond building_from_rig(
      Eigen::AngleAxisd(heading_rad, Eigen::Vector3d::UnitZ()) * Eigen::Quaterniond(upright));
  OrientationFrame made;
  made.id = OrientationFrameId{id};
  made.sequence = SequenceId{sequence};
  made.frame = frame;
  made.reliable = true;
  made.rotation = BuildingRotation{building_from_rig, Eigen::Matrix3d::Zero()};
  return made;
}

// Frames 0 to count - 1 of a sequence.
void Add(OrientationLayer& layer, int64_t sequence, int count, double heading_rad) {
  for (int i = 0; i < count; ++i) {
    const auto id = static_cast<int64_t>(layer.frames.size()) + 1;
    layer.frames.push_back(FrameAt(id, sequence, i, heading_rad));
  }
}

void ExpectAt(const Eigen::Vector2d& point, double x, double y) {
  EXPECT_EQ(point.x(), x);
  EXPECT_EQ(point.y(), y);
}

// Frames first to last of one sequence look elsewhere.
void Look(OrientationLayer& layer, int first, int last, double heading_rad) {
  for (int i = first; i <= last; ++i) {
    layer.frames[i].rotation = FrameAt(1, 1, 0, heading_rad).rotation;
  }
}

TEST(ComputeTrajectory, ConfirmedTurnsBendItAndFalseOnesDont) {
  OrientationLayer layer;
  Add(layer, 1, 12, 0.2);
  Look(layer, 4, 7, 1.5);
  Look(layer, 6, 6, 3);  // the camera alone
  Look(layer, 8, 11, 3);
  layer.turns = {{OrientationFrameId{4}, 1, 1.5, true, 1},   // left, along y
                 {OrientationFrameId{7}, 1, 1.5, false, 0},  // the camera alone
                 {OrientationFrameId{8}, 1, 1.5, true, 0}};  // left again, against x
  const std::vector<Eigen::Vector2d> trajectory = ComputeTrajectory(layer);
  ASSERT_EQ(trajectory.size(), 12U);
  ExpectAt(trajectory[0], 0, 0);
  ExpectAt(trajectory[3], 3, 0);  // the turn's frame is where it was seen
  ExpectAt(trajectory[4], 3, 1);
  ExpectAt(trajectory[7], 3, 4);
  ExpectAt(trajectory[11], -1, 4);
}

// What comes before a turn runs along the other axis, wherever its first frames look.
TEST(ComputeTrajectory, TheFirstTurnSettlesTheBeginning) {
  OrientationLayer layer;
  Add(layer, 1, 8, -1.4);
  Look(layer, 0, 2, 0);
  Look(layer, 6, 7, 3.1);
  layer.turns = {{OrientationFrameId{6}, -1, -1.5, true, 0}};
  ExpectAt(ComputeTrajectory(layer)[5], 0, -5);
  ExpectAt(ComputeTrajectory(layer)[7], -2, -5);
}

TEST(ComputeTrajectory, ACameraThatLooksAsideGoesByTheTurns) {
  OrientationLayer layer;
  Add(layer, 1, 4, -1.55);  // the motion is along x, the camera looks to its right
  Add(layer, 1, 4, 3.1);
  for (int i = 4; i < 8; ++i) layer.frames[i].frame = i;
  layer.turns = {{OrientationFrameId{4}, -1, -1.5, true, 1}};
  const std::vector<Eigen::Vector2d> trajectory = ComputeTrajectory(layer);
  EXPECT_EQ(std::abs(trajectory[3].x()), 3);
  ExpectAt(trajectory[7] - trajectory[3], 0, trajectory[3].x() > 0 ? -4 : 4);
}

TEST(ComputeTrajectory, SequencesBeginAnewAlongTheirFirstHeading) {
  OrientationLayer layer;
  Add(layer, 1, 3, 0);
  Add(layer, 2, 4, -1.4);
  layer.frames[3].reliable = false;  // its rotation isn't believed, the next one's is
  layer.frames[3].rotation = std::nullopt;
  layer.frames[6].frame = 9;  // steps count frames, also those that are missing
  const std::vector<Eigen::Vector2d> trajectory = ComputeTrajectory(layer);
  ExpectAt(trajectory[2], 2, 0);
  ExpectAt(trajectory[3], 0, 0);
  ExpectAt(trajectory[5], 0, -2);
  ExpectAt(trajectory[6], 0, -9);
  EXPECT_TRUE(ComputeTrajectory({}).empty());
}

}  // namespace
}  // namespace waystone
