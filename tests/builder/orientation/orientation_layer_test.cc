// SPDX-License-Identifier: Apache-2.0
#include "builder/orientation/orientation_layer.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <memory>

#include "builder/frames/frame_pipeline.h"
#include "builder/orientation/follow.h"
#include "builder/sources/memory_source.h"
#include "core/base/error.h"
#include "schema/file/map_problems.h"
#include "world/render.h"
#include "world/rig.h"
#include "world/walk.h"
#include "world/world.h"

namespace waystone {
namespace {

// Around a corner to the right, in a corridor 1.5 m wide.
constexpr const char* kPlan = R"(
####################
#..................#
#..................#
#..................#
################...#
################...#
################...#
################...#
################...#
################...#
####################
)";

struct Made {
  std::vector<Eigen::Isometry3d> poses;
  std::vector<cv::Mat> images;
  Camera camera = PinholeCamera(320, 240, 1.3);
};

// Rendered once for all tests.
const Made& Corner() {
  static const Made corner = [] {
    Made made;
    WorldOptions look;
    look.texel_m = 0.01;
    look.texture_richness = 0.4;
    const World world(ParseFloorPlan(kPlan), look);
    WalkOptions options;
    options.gaze_rad = 0;
    options.sway = 0.3;
    options.step_m = 0.12;
    options.turn_rad = 0.12;
    const Walk walk = WalkThrough(world.plan(), {{2.5, 2.5}, {17.5, 2.5}, {17.5, 9}}, options);
    const Renderer renderer(made.camera);
    for (const WalkFrame& frame : walk.frames) {
      made.poses.push_back(frame.world_from_camera);
      made.images.push_back(renderer.Render(world, frame.world_from_camera).grey);
    }
    return made;
  }();
  return corner;
}

struct Built {
  OrientationLayer layer;
  OrientationReport report;
};

Built BuildOrientation(const std::vector<cv::Mat>& images, int threads = tbb::task_arena::automatic,
                       const ProgressCallback& progress = {}) {
  MemorySource source(
      {.name = "corner", .frames = FramesOfImages(images), .camera = Corner().camera});
  OrientationLayerBuilder builder(OrientationOptions{});
  tbb::task_arena arena(threads);
  MapData map = arena.execute([&] { return BuildLayer({&source}, builder, progress); });
  return {std::move(*map.orientation), builder.report()};
}

MapData MapWith(OrientationLayer layer) {
  MapData map;
  map.sequences.push_back({.id = {1}, .name = "corner", .kind = "folder", .camera = {}});
  map.orientation = std::move(layer);
  return map;
}

double TrueHeading(int i) {
  const Eigen::Vector3d gaze = Corner().poses[i].linear().col(2);
  return std::atan2(gaze.y(), gaze.x());  // the walk starts along the world's x
}

TEST(OrientationLayer, FindsTheTurnTheHeadingsAndTheWay) {
  const Built result = BuildOrientation(Corner().images);
  const OrientationLayer& layer = result.layer;
  ASSERT_EQ(layer.frames.size(), Corner().images.size());
  // A narrow view of upright lines mostly: many frames are believed by the features' rotation, up
  // to FollowOptions::max_drift_rad and what that is off itself.
  int reliable = 0;
  int exact = 0;
  for (size_t i = 0; i < layer.frames.size(); ++i) {
    if (!layer.frames[i].reliable) continue;
    ++reliable;
    const double off =
        std::abs(HeadingOf(layer.frames[i]).value() - TrueHeading(static_cast<int>(i)));
    EXPECT_LT(off, 0.1) << i;
    exact += off < 0.05 ? 1 : 0;
  }
  EXPECT_GT(reliable, 0.5 * static_cast<double>(layer.frames.size()));
  EXPECT_GT(exact, 0.95 * reliable);
  ASSERT_EQ(layer.turns.size(), 1U);
  EXPECT_TRUE(layer.turns[0].confirmed);
  EXPECT_EQ(layer.turns[0].direction, -1);
  EXPECT_EQ(layer.turns[0].axis_after, 1);
  EXPECT_NEAR(TrueHeading(static_cast<int>(layer.turns[0].frame.value - 1)), -0.785, 0.2);
  EXPECT_GE(layer.nodes.size(), 3U);
  EXPECT_GE(layer.edges.size(), 2U);
  EXPECT_FALSE(layer.nodes[0].jpeg.empty());
  std::vector<MapProblem> problems = FindMapProblems(MapWith(layer));
  EXPECT_TRUE(problems.empty()) << problems[0].where << ": " << problems[0].message;
}

TEST(OrientationLayer, IsTheSameOnAnyNumberOfThreads) {
  const std::vector<cv::Mat> images(Corner().images.begin(), Corner().images.begin() + 12);
  EXPECT_TRUE(BuildOrientation(images, 1).layer == BuildOrientation(images, 2).layer);
}

TEST(OrientationLayer, BlackAndMissingFramesAreKeptWithoutARotationAndTheRestIsMapped) {
  std::vector<cv::Mat> images(Corner().images.begin(), Corner().images.begin() + 30);
  images[10] = cv::Mat(240, 320, CV_8UC1, cv::Scalar(0));
  images[20] = cv::Mat();
  const Built result = BuildOrientation(images);
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

// The camera turns the corner in the dark: which way it looks then can't be told from axes alone.
TEST(OrientationLayer, AQuarterTurnIsNotGuessedOverAGap) {
  std::vector<cv::Mat> images = Corner().images;
  int turns = 0;
  for (size_t i = 0; i < images.size(); ++i) {
    const double heading = std::abs(TrueHeading(static_cast<int>(i)));
    if (heading < 0.15 || heading > 1.4) continue;
    images[i] = cv::Mat(240, 320, CV_8UC1, cv::Scalar(0));
    ++turns;
  }
  ASSERT_GT(turns, 5);
  const Built result = BuildOrientation(images);
  for (size_t i = 0; i < images.size(); ++i) {
    const OrientationFrame& frame = result.layer.frames[i];
    if (!frame.reliable) continue;
    EXPECT_NEAR(*HeadingOf(frame), TrueHeading(static_cast<int>(i)), 0.1) << i;
  }
  EXPECT_TRUE(FindMapProblems(MapWith(result.layer)).empty());
}

TEST(OrientationLayer, RefusesASequenceOfWhichNothingCanBeRead) {
  try {
    BuildOrientation({cv::Mat(), cv::Mat(100, 100, CV_8UC1, cv::Scalar(0))});
    FAIL();
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadSource);
    EXPECT_NE(std::string(error.what()).find("none of 2 frames"), std::string::npos);
  }
}

TEST(OrientationLayer, CanBeStopped) {
  const auto stop = [](const BuildProgress& now) { return now.done < 3; };
  try {
    BuildOrientation(Corner().images, 2, stop);
    FAIL();
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInterrupted);
  }
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
