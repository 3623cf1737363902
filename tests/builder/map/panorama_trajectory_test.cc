// SPDX-License-Identifier: Apache-2.0
// What whole drives become in the appearance layer.
#include <gtest/gtest.h>

#include <vector>

#include "tests/builder/appearance/drive.h"
#include "world/flat.h"

namespace waystone {
namespace {

TEST(PanoramaTrajectoryTest, LoopsBringTheWayNearerToTheTruth) {
  const BuiltAppearance result = BuildFromImages(TheDrive().panoramas);
  const Points2 truth = PlacesOf(TheDrive().truth);
  const AppearanceReport& report = result.report;
  EXPECT_EQ(report.panoramas, Drive::kFrames);
  EXPECT_GE(report.loops_supported - report.loops_rejected, 3);
  EXPECT_LT(CompareShapes(truth, PlacesOf(report.poses)).mu, 0.02);
  EXPECT_LE(CompareShapes(truth, PlacesOf(report.poses)).mu,
            CompareShapes(truth, PlacesOf(report.odometry)).mu);
}

TEST(PanoramaTrajectoryTest, SaysWhereTheTrajectoryIsDoubtful) {
  EXPECT_FALSE(BuildFromImages(FirstPanoramas(12)).report.IsTrajectoryDoubtful());
  // Through a flat with a panorama a room and one in each doorway: steps as long as the rooms.
  FlatTourOptions tour;
  tour.per_room = 1;
  tour.camera.width_px = 256;
  std::vector<cv::Mat> images;
  for (const FlatPanorama& panorama : PhotographFlat(MakeFlat({}), tour)) {
    images.push_back(panorama.grey);
  }
  const AppearanceReport report = BuildFromImages(images).report;
  EXPECT_EQ(report.steps, static_cast<int>(images.size()) - 1);
  EXPECT_GT(report.uncertain, report.steps / 2);
  EXPECT_TRUE(report.IsTrajectoryDoubtful());
}

TEST(PanoramaTrajectoryTest, LeavesOutWhatIsRedundant) {
  AppearanceOptions options = ShortDrive();
  options.redundancy.max_loss = 0.6;
  const BuiltAppearance result = BuildFromImages(TheDrive().panoramas, options);
  EXPECT_GT(result.layer.dropped, 0);
  EXPECT_EQ(std::ssize(result.layer.nodes) + result.layer.dropped, Drive::kFrames);
  EXPECT_GE(result.layer.edges.size(), result.layer.nodes.size() - 1);
}

TEST(PanoramaTrajectoryTest, TiesSequencesTogetherByTheirLoops) {
  const auto& all = TheDrive().panoramas;
  MemorySource first = ImagesSource({all.begin(), all.begin() + 28}, "first");
  MemorySource second = ImagesSource({all.begin() + 16, all.end()}, "second");
  const BuiltAppearance result = BuildAppearance({&first, &second}, ShortDrive());
  ASSERT_EQ(result.report.poses.size(), 28 + 32);
  Points2 truth = PlacesOf({TheDrive().truth.begin(), TheDrive().truth.begin() + 28});
  for (int i = 16; i < Drive::kFrames; ++i) {
    truth.emplace_back(TheDrive().truth[i].x, TheDrive().truth[i].y);
  }
  EXPECT_LT(CompareShapes(truth, PlacesOf(result.report.poses)).mu, 0.03);
}

}  // namespace
}  // namespace waystone
