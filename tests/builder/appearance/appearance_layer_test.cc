// SPDX-License-Identifier: Apache-2.0
#include "builder/appearance/appearance_layer.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include "core/base/error.h"
#include "tests/builder/appearance/drive.h"
#include "world/flat.h"

namespace waystone {
namespace {

BuiltAppearance BuildFromImages(const std::vector<cv::Mat>& images,
                                const AppearanceOptions& options = ShortDrive()) {
  MemorySource source = ImagesSource(images);
  return BuildAppearance({&source}, options);
}

// A new image: assigning zeros to one would blacken all that share its pixels.
cv::Mat Black(const cv::Size& size) { return {size, CV_8UC1, cv::Scalar(0)}; }

void ExpectRefused(const std::vector<cv::Mat>& images, const std::vector<std::string>& parts) {
  try {
    BuildFromImages(images);
    ADD_FAILURE() << "nothing was thrown";
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadSource) << error.what();
    for (const std::string& part : parts) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  }
}

TEST(BuildAppearanceTest, LoopsBringTheWayNearerToTheTruth) {
  const BuiltAppearance result = BuildFromImages(TheDrive().panoramas);
  const Points2 truth = PlacesOf(TheDrive().truth);
  const AppearanceReport& report = result.report;
  EXPECT_EQ(report.panoramas, Drive::kFrames);
  EXPECT_GE(report.loops_supported - report.loops_rejected, 3);
  EXPECT_LT(CompareShapes(truth, PlacesOf(report.poses)).mu, 0.02);
  EXPECT_LE(CompareShapes(truth, PlacesOf(report.poses)).mu,
            CompareShapes(truth, PlacesOf(report.odometry)).mu);
}

TEST(BuildAppearanceTest, SaysWhereTheTrajectoryIsDoubtful) {
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

TEST(BuildAppearanceTest, IsTheSameForAnyNumberOfThreads) {
  const BuiltAppearance many = BuildFromImages(FirstPanoramas(12));
  tbb::task_arena one(1);
  EXPECT_EQ(one.execute([] { return BuildFromImages(FirstPanoramas(12)); }).layer, many.layer);
}

TEST(BuildAppearanceTest, LeavesOutWhatIsRedundant) {
  AppearanceOptions options = ShortDrive();
  options.redundancy.max_loss = 0.6;
  const BuiltAppearance result = BuildFromImages(TheDrive().panoramas, options);
  EXPECT_GT(result.layer.dropped, 0);
  EXPECT_EQ(std::ssize(result.layer.nodes) + result.layer.dropped, Drive::kFrames);
  EXPECT_GE(result.layer.edges.size(), result.layer.nodes.size() - 1);
}

TEST(BuildAppearanceTest, TiesSequencesTogetherByTheirLoops) {
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

TEST(BuildAppearanceTest, SkipsAndNamesABlackPanorama) {
  std::vector<cv::Mat> images = FirstPanoramas(6);
  images[2] = Black(images[2].size());
  const BuiltAppearance result = BuildFromImages(images);
  EXPECT_EQ(result.report.skipped, 1);
  EXPECT_EQ(result.sequences[0].skipped, 1);
  EXPECT_EQ(result.layer.nodes.size(), 5);
  ASSERT_EQ(result.report.skipped_names.size(), 1);
  EXPECT_NE(result.report.skipped_names[0].find("image 2: "), std::string::npos);
}

TEST(BuildAppearanceTest, RefusesASequenceOfOne) {
  ExpectRefused(FirstPanoramas(1), {"'drive' has 1 usable panorama of 1 frame", "at least two"});
}

TEST(BuildAppearanceTest, RefusesASequenceThatIsAllBlack) {
  ExpectRefused(std::vector<cv::Mat>(3, cv::Mat::zeros(128, 256, CV_8UC1)),
                {"0 usable panoramas of 3 frames", "first: image 0"});
}

TEST(BuildAppearanceTest, StopsWhenToldToInTheMiddleOfAStage) {
  for (const std::string at : {"panoramas", "odometry", "loops", "poses"}) {
    int calls = 0;  // of that stage; the first one is before it begins
    const auto stop = [&](const BuildProgress& now) {
      return now.stage != at || (++calls == 1 && at != "panoramas" && at != "poses");
    };
    try {
      MemorySource source = ImagesSource(at == "loops" ? TheDrive().panoramas : FirstPanoramas(6));
      BuildAppearance({&source}, ShortDrive(), stop);
      ADD_FAILURE() << "nothing was thrown in " << at;
    } catch (const MapError& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInterrupted);
    }
  }
}

}  // namespace
}  // namespace waystone
