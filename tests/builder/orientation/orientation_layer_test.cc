// SPDX-License-Identifier: Apache-2.0
#include "builder/orientation/orientation_layer.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <memory>
#include <opencv2/imgproc.hpp>

#include "builder/frames/frame_pipeline.h"
#include "builder/orientation/follow.h"
#include "builder/sources/memory_source.h"
#include "core/base/error.h"
#include "schema/file/map_problems.h"
#include "tests/builder/orientation/corner.h"

namespace waystone {
namespace {

TEST(OrientationLayer, IsTheSameOnAnyNumberOfThreads) {
  const std::vector<cv::Mat> images(Corner().images.begin(), Corner().images.begin() + 12);
  EXPECT_TRUE(BuildOrientation(images, 1).layer == BuildOrientation(images, 2).layer);
}

TEST(OrientationLayer, BlackAndMissingFramesAreKeptWithoutARotationAndTheRestIsMapped) {
  std::vector<cv::Mat> images(Corner().images.begin(), Corner().images.begin() + 30);
  images[10] = cv::Mat(240, 320, CV_8UC1, cv::Scalar(0));
  images[20] = cv::Mat();
  const BuiltOrientation result = BuildOrientation(images);
  EXPECT_EQ(result.report.skipped, 1);
  ASSERT_EQ(result.report.skipped_names.size(), 1U);
  EXPECT_EQ(result.report.skipped_names[0], "20: no image");
  ASSERT_EQ(result.layer.frames.size(), 30U);
  for (const int bad : {10, 20}) EXPECT_FALSE(result.layer.frames[bad].reliable);
  for (const int good : {9, 11, 19, 21}) EXPECT_TRUE(result.layer.frames[good].reliable) << good;
  for (const OrientationNode& node : result.layer.nodes) {
    EXPECT_NE(node.frame.value - 1, 10);
    EXPECT_NE(node.frame.value - 1, 20);
  }
  EXPECT_TRUE(FindMapProblems(MapWith(result.layer)).empty());
}

// Axes that aren't settled yet make a short sequence wait for its first node.
TEST(OrientationLayer, AShortSequenceThatEndsInTheDarkHasANode) {
  std::vector<cv::Mat> images(Corner().images.begin(), Corner().images.begin() + 4);
  for (cv::Mat& image : images) cv::GaussianBlur(image, image, {}, 2);
  images.emplace_back(240, 320, CV_8UC1, cv::Scalar(0));
  OrientationOptions never;
  never.manhattan.max_sigma_rad = 1e-4;
  const BuiltOrientation result = BuildOrientation(images, 2, {}, never);
  for (const OrientationFrame& frame : result.layer.frames) EXPECT_FALSE(frame.reliable);
  ASSERT_EQ(result.layer.nodes.size(), 1U);
  EXPECT_EQ(result.layer.nodes[0].frame.value - 1, 3);
}

TEST(OrientationLayer, RefusesASequenceOfWhichNothingCanBeRead) {
  try {
    BuildOrientation({cv::Mat(), cv::Mat(100, 100, CV_8UC1, cv::Scalar(0))});
    FAIL();
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadSource);
    EXPECT_NE(std::string(error.what()).find("none of the 2 frames"), std::string::npos);
  }
}

void ExpectStops(const ProgressCallback& stop) {
  try {
    BuildOrientation(Corner().images, 2, stop);
    FAIL();
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInterrupted);
  }
}

TEST(OrientationLayer, CanBeStopped) {
  ExpectStops([](const BuildProgress& now) { return now.done < 3; });
}

TEST(OrientationLayer, CanBeStoppedWhileItLooksForLoops) {
  ExpectStops([](const BuildProgress& now) { return now.stage != "loops"; });
}

TEST(OrientationLayer, RefusesASourceWithoutACamera) {
  MemorySource source({.name = "photos", .frames = FramesOfImages({Corner().images[0]})});
  OrientationLayerBuilder builder(OrientationOptions{});
  try {
    BuildLayer({&source}, builder);
    FAIL();
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadCamera);
  }
}

TEST(OrientationOptions, RefuseWhatIsOutOfRange) {
  OrientationOptions options;
  options.Check();
  options.step = 0;
  EXPECT_THROW(options.Check(), MapError);
  options = {};
  options.turns.reach = 0;
  EXPECT_THROW(options.Check(), MapError);
}

}  // namespace
}  // namespace waystone
