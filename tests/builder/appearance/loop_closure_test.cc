// SPDX-License-Identifier: Apache-2.0
#include "builder/appearance/loop_closure.h"

#include <gtest/gtest.h>

#include "builder/appearance/redundancy.h"
#include "tests/builder/appearance/drive.h"

namespace waystone {
namespace {

LoopOptions ShortLoops() {
  LoopOptions options;
  options.min_gap = 20;  // the drive is a short one
  return options;
}

LoopClosure LoopsOf(const std::vector<FourierSignature>& signatures, const LoopOptions& options) {
  VisualOdometryOptions odometry;
  odometry.max_span = 1;  // fast
  const VisualOdometry trajectory = FollowPanoramas(signatures, kBand, odometry);
  return CloseLoops(signatures, kBand, {{0, static_cast<int>(signatures.size())}}, {trajectory}, {},
                    options);
}

TEST(LoopClosureTest, FindsWhereTheWayComesBack) {
  const LoopClosure closure = LoopsOf(DriveSignatures(), ShortLoops());
  ASSERT_GE(closure.loops.size(), 3);
  EXPECT_EQ(closure.loops.size(), closure.edges.size());
  for (const PanoramaRelation& loop : closure.loops) {
    EXPECT_NEAR(loop.b - loop.a, Drive::kAround, 3);
    const Pose2 truth = Inverse(TheDrive().truth[loop.a]) * TheDrive().truth[loop.b];
    EXPECT_NEAR(WrappedAngle(loop.a_from_b.theta_rad - truth.theta_rad), 0, 0.05);
  }
}

TEST(LoopClosureTest, FindsNoneInAWayThatDoesNotComeBack) {
  std::vector<FourierSignature> signatures = DriveSignatures();
  signatures.resize(30);
  EXPECT_TRUE(LoopsOf(signatures, ShortLoops()).loops.empty());
}

// One panorama that looks like another place is no loop: its neighbours don't look like that
// place's neighbours.
TEST(LoopClosureTest, ALookAlikeWithoutNeighboursIsNoLoop) {
  std::vector<FourierSignature> signatures = DriveSignatures();
  signatures.resize(30);
  signatures[27] = signatures[2];
  const LoopClosure closure = LoopsOf(signatures, ShortLoops());
  EXPECT_GE(closure.certain, 1);
  EXPECT_TRUE(closure.loops.empty());
  LoopOptions credulous = ShortLoops();
  credulous.min_supporters = 0;
  EXPECT_GE(LoopsOf(signatures, credulous).loops.size(), 1);
}

TEST(RedundancyTest, KeepsAllByDefaultAndFewerForMoreLoss) {
  const std::vector<FourierSignature> signatures = DriveSignatures();
  const std::vector<PanoramaStretch> stretches = {{0, 20}, {20, Drive::kFrames}};
  const auto kept = [&](double max_loss) {
    return KeepInformative(signatures, TheDrive().truth, stretches, {.max_loss = max_loss});
  };
  const auto count = [&](double max_loss) { return std::ranges::count(kept(max_loss), true); };
  EXPECT_EQ(count(0), Drive::kFrames);
  EXPECT_LT(count(0.5), Drive::kFrames);
  EXPECT_LT(count(0.9), count(0.5));
  for (const int end : {0, 19, 20, Drive::kFrames - 1}) EXPECT_TRUE(kept(0.9)[end]) << end;
}

}  // namespace
}  // namespace waystone
