// SPDX-License-Identifier: Apache-2.0
// Keyframes of a made building that are read and matched again, against the walk's true poses.
#include "builder/poses/keyframe_matches.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <Eigen/Dense>
#include <functional>
#include <string>

#include "builder/poses/keyframe_reader.h"
#include "core/base/error.h"
#include "tests/builder/map/stage.h"

namespace waystone {
namespace {

std::vector<std::unique_ptr<Source>> OpenSources(int count, int frames = 45,
                                                 const std::set<int>& broken = {}) {
  std::vector<std::unique_ptr<Source>> sources;
  for (int i = 0; i < count; ++i) sources.push_back(OpenStage(frames, broken));
  return sources;
}

std::string ReadingError(const MapData& map, const std::vector<std::unique_ptr<Source>>& sources) {
  try {
    ReadKeyframes(map, sources, {});
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadSource);
    return error.what();
  }
  return "";
}

// Distance of x_b from the true epipolar line of x_a, px.
double TrueError(const Keyframe& a, const Keyframe& b, const Eigen::Vector2d& x_a,
                 const Eigen::Vector2d& x_b) {
  const Camera& camera = TheStage().renderer.camera();
  const auto pose = [](const Keyframe& keyframe) {
    return TheStage().walk.frames[keyframe.frame].world_from_camera;
  };
  const Eigen::Isometry3d b_from_a = pose(b).inverse() * pose(a);
  const Eigen::Vector3d ray = b_from_a.linear() * Unproject(camera, x_a);
  const Eigen::Vector3d normal = b_from_a.translation().cross(ray);
  const double off = Unproject(camera, x_b).dot(normal) / normal.norm();
  return std::abs(off) * camera.params[0];
}

TEST(KeyframeReader, GivesTheFeaturesOfEachKeyframe) {
  const MapData& map = TheMap().map;
  const auto read = ReadKeyframes(map, OpenSources(1), {});
  ASSERT_EQ(read.size(), map.keyframes.size());
  for (size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].keyframe, map.keyframes[i].id);
    const Features features =
        ExtractFeatures(TheStage().frames[map.keyframes[i].frame], FeatureOptions());
    EXPECT_EQ(read[i].features.keypoints, features.keypoints);
  }
}

// The map is in pixels of its working images, a reconstruction in those of the images.
TEST(KeyframeReader, TakesImagesThatAreLargerThanTheMapsOwn) {
  BuildOptions options;
  options.images = false;
  options.features.working_pixels = 160 * 120;
  const MapData map = BuildMap(OpenSources(1), options, {}).map;
  ASSERT_EQ(map.keyframes[0].width, 160);
  const auto read = ReadKeyframes(map, OpenSources(1), {});
  ASSERT_EQ(read.size(), map.keyframes.size());
  EXPECT_EQ(read[0].features.width, 320);
  MapData other = map;
  other.keyframes[0].height = 130;
  EXPECT_NE(ReadingError(other, OpenSources(1)).find("is 320x240 px, the map's is 160x130"),
            std::string::npos);
  other = map;
  other.sequences[0].camera = PinholeCamera(640, 480, 1.2);
  EXPECT_NE(ReadingError(other, OpenSources(1)).find("the map's camera has 640x480"),
            std::string::npos);
}

TEST(KeyframeReader, RefusesWhatTheMapWasNotBuiltFrom) {
  const MapData& map = TheMap().map;
  EXPECT_NE(ReadingError(map, OpenSources(2)).find("1 sequences, but 2 were given"),
            std::string::npos);
  EXPECT_NE(ReadingError(map, OpenSources(1, 2)).find("of the map's"), std::string::npos);
  const int broken = map.keyframes[1].frame;
  EXPECT_NE(ReadingError(map, OpenSources(1, 45, {broken})).find("made unreadable"),
            std::string::npos);
  MapData renamed = map;
  renamed.keyframes[0].source = "other.jpg";
  EXPECT_NE(ReadingError(renamed, OpenSources(1)).find("the map's is other.jpg"),
            std::string::npos);
  renamed = map;
  renamed.keyframes[0].width = 641;
  EXPECT_NE(ReadingError(renamed, OpenSources(1)).find("the map's is 641x240"), std::string::npos);
}

TEST(KeyframeMatches, AgreeWithTheTruePoses) {
  const auto index = MapIndex::Build(TheMap().map);
  const MapData& map = index->map();
  const auto features = ReadKeyframes(map, OpenSources(1), {});
  const auto matched = MatchKeyframes(*index, features);
  std::set<std::pair<int, int>> pairs;
  int right = 0;
  int all = 0;
  for (const MatchedKeyframes& pair : matched) {
    EXPECT_LT(pair.a, pair.b);
    EXPECT_TRUE(pairs.insert({pair.a, pair.b}).second);
    EXPECT_GE(pair.matches.features.size(), 15U);
    for (const auto& [a, b] : pair.matches.features) {
      const double error = TrueError(map.keyframes[pair.a], map.keyframes[pair.b],
                                     PositionOf(features[pair.a].features.keypoints[a]),
                                     PositionOf(features[pair.b].features.keypoints[b]));
      right += error < 3;
      ++all;
    }
  }
  for (int i = 0; i + 1 < std::ssize(map.keyframes); ++i) EXPECT_TRUE(pairs.contains({i, i + 1}));
  EXPECT_GT(right, 0.95 * all) << right << " of " << all;
}

TEST(KeyframeMatches, JoinVisitsOfOnePlace) {
  BuildOptions options;
  options.images = false;
  const auto index = MapIndex::Build(BuildMap(OpenSources(2), options, {}).map);
  const MapData& map = index->map();
  const auto features = ReadKeyframes(map, OpenSources(2), {});
  int between = 0;
  for (const MatchedKeyframes& pair : MatchKeyframes(*index, features)) {
    between += map.keyframes[pair.a].sequence != map.keyframes[pair.b].sequence;
  }
  EXPECT_GE(between, std::ssize(map.keyframes) / 2);
}

TEST(KeyframeMatches, AreTheSameOnAnyNumberOfThreads) {
  const auto index = MapIndex::Build(TheMap().map);
  const auto features = ReadKeyframes(index->map(), OpenSources(1), {});
  const auto match = [&](int threads) {
    std::vector<MatchedKeyframes> matched;
    tbb::task_arena(threads).execute([&] { matched = MatchKeyframes(*index, features); });
    return matched;
  };
  const auto one = match(1);
  const auto four = match(4);
  ASSERT_EQ(one.size(), four.size());
  for (size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].a, four[i].a);
    EXPECT_EQ(one[i].b, four[i].b);
    EXPECT_EQ(one[i].matches.features, four[i].matches.features);
  }
}

}  // namespace
}  // namespace waystone
