// SPDX-License-Identifier: Apache-2.0
// Maps with landmarks beside planes, without them, and of a place that was only turned in.
#include <gtest/gtest.h>

#include <algorithm>

#include "localizer/localizer.h"
#include "tests/builder/map/stage.h"
#include "tests/builder/sources/frames_of_images.h"

namespace waystone {
namespace {

MapData BuildWith(int landmarks) {
  BuildOptions options;
  options.planes.landmarks.max_kept = landmarks;
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(OpenStage(45));
  return BuildMap(sources, options, {}).map;
}

int CountLandmarks(const MapData& map) {
  int count = 0;
  for (const Keyframe& keyframe : map.keyframes) count += keyframe.landmarks.size();
  return count;
}

TEST(LandmarkMap, KeepsThemBesideThePlanes) {
  const MapData& map = TheMap().map;
  EXPECT_GT(CountLandmarks(map), 10 * std::ssize(map.keyframes));
  for (const Keyframe& keyframe : map.keyframes) {
    EXPECT_LE(keyframe.landmarks.size(), LandmarkOptions{}.max_kept);
  }
}

// The planes and the graph don't depend on landmarks.
TEST(LandmarkMap, NoneLeavesPlanesAlone) {
  const MapData map = BuildWith(0);
  EXPECT_EQ(CountLandmarks(map), 0);
  const MapData& with = TheMap().map;
  ASSERT_EQ(map.planes.size(), with.planes.size());
  for (size_t i = 0; i < map.planes.size(); ++i) {
    EXPECT_EQ(map.planes[i].features, with.planes[i].features);
    EXPECT_EQ(map.planes[i].views, with.planes[i].views);
  }
  EXPECT_EQ(map.edges, with.edges);
  const auto index = MapIndex::Build(map);
  EXPECT_FALSE(index->HasLandmarks());
  const Answer answer = LocalizeImage(*index, TheStage().frames[20], {});
  EXPECT_EQ(answer.verdict, Verdict::kLocalized);
  EXPECT_FALSE(answer.planes.epipolar);
}

// Eight photos from a tripod: no parallax, so no plane.
TEST(LandmarkMap, APlaceThatWasOnlyTurnedInIsFound) {
  const MadeStage& stage = TheStage();
  std::vector<cv::Mat> photos;
  const Eigen::Isometry3d stand = stage.walk.frames[10].world_from_camera;
  for (int i = 0; i < 9; ++i) {
    Eigen::Isometry3d turned = stand;
    turned.rotate(Eigen::AngleAxisd(0.01 * i, Eigen::Vector3d::UnitY()));
    photos.push_back(stage.renderer.Render(stage.world, turned).grey);
  }
  const cv::Mat query = photos.back();
  photos.pop_back();
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::make_unique<MemorySource>(
      MemorySequence{.name = "tripod", .frames = FramesOfImages(photos)}));
  const MapData map = BuildMap(sources, {}, {}).map;
  EXPECT_TRUE(map.planes.empty());
  EXPECT_GT(CountLandmarks(map), 0);
  const auto index = MapIndex::Build(map);
  const Answer answer = LocalizeImage(*index, query, {});
  EXPECT_EQ(answer.verdict, Verdict::kLocalized) << answer.message;
  EXPECT_TRUE(answer.planes.recognised.empty());
  EXPECT_TRUE(answer.planes.epipolar);
  EXPECT_EQ(LocalizeImage(*index, stage.frames[44], {}).verdict, Verdict::kNotInMap);
}

}  // namespace
}  // namespace waystone
