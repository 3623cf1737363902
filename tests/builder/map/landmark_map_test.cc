// SPDX-License-Identifier: Apache-2.0
// Maps with landmarks beside planes, without them, and of a place that was only turned in.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <utility>

#include "core/camera/image_plane.h"
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

// A telephone may be held on its side, and its pictures may be larger than the map's.
TEST(LandmarkMap, TheNearestKeyframeDoesNotDependOnHowTheCameraIsHeld) {
  const auto index = MapIndex::Build(TheMap().map);
  const auto nearest = [&](const cv::Mat& photo) {
    const Answer answer = LocalizeImage(*index, photo, {});
    return answer.verdict == Verdict::kLocalized
               ? index->FindKeyframe(answer.planes.keyframe->id)->frame
               : -1;
  };
  for (int i = 2; i < 45; i += 6) {
    const cv::Mat& frame = TheStage().frames[i];
    const int upright = nearest(frame);
    ASSERT_GE(upright, 0) << i;
    for (const int turn :
         {cv::ROTATE_90_CLOCKWISE, cv::ROTATE_180, cv::ROTATE_90_COUNTERCLOCKWISE}) {
      cv::Mat turned;
      cv::rotate(frame, turned, turn);
      EXPECT_EQ(nearest(turned), upright) << i << ", turn " << turn;
    }
    cv::Mat larger;
    cv::resize(frame, larger, {}, 2, 2, cv::INTER_CUBIC);
    EXPECT_EQ(nearest(larger), upright) << i;
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

// Frames of the stage as a sequence.
std::unique_ptr<Source> OpenFrames(const std::string& name, int first, int last) {
  MemorySequence sequence{.name = name, .camera = {}};
  for (int i = first; i <= last; ++i) {
    sequence.frames.emplace_back(FrameInfo{i, "frame " + std::to_string(i), i / 15.0},
                                 [i] { return TheStage().frames[i]; });
  }
  return std::make_unique<MemorySource>(std::move(sequence));
}

// The beginning of a walk and its end, from where the same room is seen: too few features are alike
// for fusing planes, but the keyframes are recognised.
TEST(LandmarkMap, KeyframesOfTwoVisitsAreLinked) {
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(OpenFrames("begin", 0, 7));
  sources.push_back(OpenFrames("end", 37, 43));
  const BuildResult built = BuildMap(sources, {}, {});
  ASSERT_FALSE(built.map.links.empty());
  EXPECT_GT(built.report.planes->keyframes_linked, 0);
  const auto index = MapIndex::Build(built.map);
  const std::vector<Keyframe>& keyframes = built.map.keyframes;
  for (const KeyframeLink& link : built.map.links) {
    EXPECT_NE(keyframes[index->IndexOf(link.a)].sequence,
              keyframes[index->IndexOf(link.b)].sequence);
  }
  for (int i = 0; i <= 44; ++i) {
    EXPECT_NE(LocalizeImage(*index, TheStage().frames[i], {}).verdict, Verdict::kAmbiguous) << i;
  }
}

// Photos of a camera that turns on the spot, to the right of where the walk looks at first: no
// parallax, so no plane.
std::vector<cv::Mat> TurnedPhotos(double first_rad, int count, double height_m) {
  const MadeStage& stage = TheStage();
  std::vector<cv::Mat> photos;
  for (int i = 0; i < count; ++i) {
    Eigen::Isometry3d turned = stage.walk.frames[10].world_from_camera;
    turned.translation().z() += height_m;
    turned.rotate(Eigen::AngleAxisd(first_rad + 0.01 * i, Eigen::Vector3d::UnitY()));
    photos.push_back(stage.renderer.Render(stage.world, turned).grey);
  }
  return photos;
}

std::unique_ptr<Source> OpenPhotos(const std::string& name, const std::vector<cv::Mat>& photos) {
  return std::make_unique<MemorySource>(
      MemorySequence{.name = name, .frames = FramesOfImages(photos)});
}

// Each visit looks as much like the second one as like the third: they are one place.
TEST(LandmarkMap, KeyframesOfThreeVisitsAreLinked) {
  std::vector<std::unique_ptr<Source>> sources;
  for (int visit = 0; visit < 3; ++visit) {
    sources.push_back(
        OpenPhotos("visit " + std::to_string(visit), TurnedPhotos(0.02 * visit, 6, 0.05 * visit)));
  }
  const MapData map = BuildMap(sources, {}, {}).map;
  ASSERT_TRUE(map.planes.empty());
  const auto index = MapIndex::Build(map);
  std::set<std::pair<SequenceId, SequenceId>> joined;
  for (const KeyframeLink& link : map.links) {
    joined.emplace(map.keyframes[index->IndexOf(link.a)].sequence,
                   map.keyframes[index->IndexOf(link.b)].sequence);
  }
  EXPECT_EQ(joined.size(), 3);
  const Answer answer = LocalizeImage(*index, TurnedPhotos(0.05, 1, 0.07).front(), {});
  EXPECT_EQ(answer.verdict, Verdict::kLocalized) << answer.message;
}

// One picture beside another, by a camera that turns from the one to the other.
std::vector<cv::Mat> Beside(const cv::Mat& left, const cv::Mat& right) {
  cv::Mat both;
  cv::hconcat(left, right, both);
  const Eigen::Matrix3d k = ImageFromCamera(TheStage().renderer.camera());
  Eigen::Matrix3d camera_from_both = k;
  camera_from_both(0, 2) += left.cols / 2.0;
  std::vector<cv::Mat> photos;
  for (int i = 0; i < 6; ++i) {
    const Eigen::AngleAxisd turn(0.01 * i, Eigen::Vector3d::UnitY());
    const Eigen::Matrix3d photo_from_both =
        k * turn.toRotationMatrix() * camera_from_both.inverse();
    cv::Mat h;
    cv::eigen2cv(photo_from_both, h);
    cv::warpPerspective(both, photos.emplace_back(), h, left.size());
  }
  return photos;
}

// The last visit shows what hangs in one place and what hangs in another, which share nothing: it
// only looks like both. Of a first visit that shows both, the others are linked with it.
TEST(LandmarkMap, KeyframesThatLookLikeTwoEarlierPlacesAreNotLinked) {
  const World world(OtherPlan(), WorldOptions{.seed = 9, .texture_richness = 0.5});
  const Walk walk = DemoWalk(world.plan());
  std::vector<cv::Mat> four;  // nothing is seen twice
  for (size_t i = 0; i < 4; ++i) {
    const WalkFrame& frame = walk.frames[i * walk.frames.size() / 4];
    four.push_back(TheStage().renderer.Render(world, frame.world_from_camera).grey);
  }
  const auto links = [](const std::vector<std::vector<cv::Mat>>& places) {
    std::vector<std::unique_ptr<Source>> sources;
    for (const std::vector<cv::Mat>& photos : places) {
      sources.push_back(OpenPhotos("place " + std::to_string(sources.size()), photos));
    }
    return BuildMap(sources, {}, {}).map.links.size();
  };
  const std::vector<cv::Mat> both = Beside(four[0], four[1]);
  const std::vector<cv::Mat> left = Beside(four[0], four[2]);
  const std::vector<cv::Mat> right = Beside(four[3], four[1]);
  EXPECT_GT(links({both, left}), 0u);
  EXPECT_GT(links({both, right}), 0u);
  EXPECT_EQ(links({left, right, both}), 0u);
}

// Another building's walk shows none of the same places.
TEST(LandmarkMap, KeyframesOfDifferentPlacesAreNotLinked) {
  const World elsewhere(OtherPlan(), WorldOptions{.seed = 9, .texture_richness = 0.5});
  const Walk walk = DemoWalk(elsewhere.plan(), WalkOptions{.step_m = 0.1});
  MemorySequence sequence{.name = "elsewhere", .camera = {}};
  for (int i = 0; i < 30; ++i) {
    cv::Mat frame = TheStage().renderer.Render(elsewhere, walk.frames[i].world_from_camera).grey;
    sequence.frames.emplace_back(FrameInfo{i, "frame " + std::to_string(i), i / 15.0},
                                 [frame] { return frame; });
  }
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(OpenFrames("begin", 0, 30));
  sources.push_back(std::make_unique<MemorySource>(std::move(sequence)));
  const MapData map = BuildMap(sources, {}, {}).map;
  const auto sequence_of = [&](KeyframeId id) {
    return std::ranges::find(map.keyframes, id, &Keyframe::id)->sequence;
  };
  for (const SequenceId each : {map.sequences.front().id, map.sequences.back().id}) {
    EXPECT_GT(std::ranges::count(map.keyframes, each, &Keyframe::sequence), 1);
  }
  for (const KeyframeLink& link : map.links) {
    EXPECT_EQ(sequence_of(link.a), sequence_of(link.b));
  }
}

// Eight photos from a tripod.
TEST(LandmarkMap, APlaceThatWasOnlyTurnedInIsFound) {
  std::vector<cv::Mat> photos = TurnedPhotos(0, 9, 0);
  const cv::Mat query = photos.back();
  photos.pop_back();
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(OpenPhotos("tripod", photos));
  const MapData map = BuildMap(sources, {}, {}).map;
  EXPECT_TRUE(map.planes.empty());
  EXPECT_GT(CountLandmarks(map), 0);
  const auto index = MapIndex::Build(map);
  const Answer answer = LocalizeImage(*index, query, {});
  EXPECT_EQ(answer.verdict, Verdict::kLocalized) << answer.message;
  EXPECT_TRUE(answer.planes.recognised.empty());
  EXPECT_TRUE(answer.planes.epipolar);
  EXPECT_EQ(LocalizeImage(*index, TheStage().frames[44], {}).verdict, Verdict::kNotInMap);
}

}  // namespace
}  // namespace waystone
