// SPDX-License-Identifier: Apache-2.0
#include "builder/build_map.h"
#include "core/robust/median.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <set>

#include "builder/planes/fusion.h"
#include "core/base/error.h"
#include "core/homography/homology.h"
#include "localizer/localizer.h"
#include "schema/file/map_store.h"
#include "tests/builder/map/stage.h"
#include "tests/builder/planes/every_pair.h"
#include "world/truth.h"

namespace waystone {
namespace {

ErrorCode CodeOf(const std::function<void()>& run) {
  try {
    run();
  } catch (const MapError& error) {
    return error.code();
  }
  return ErrorCode::kInternal;
}

TEST(BuildMap, FindsPlanesAndJoinsThem) {
  const MapData& map = TheMap().map;
  EXPECT_GE(map.keyframes.size(), 4u);
  EXPECT_GE(map.planes.size(), 3u);
  EXPECT_FALSE(map.edges.empty());
  for (size_t i = 0; i < map.planes.size(); ++i) {
    EXPECT_EQ(map.planes[i].id.value, static_cast<int64_t>(i) + 1);
  }
  for (const Edge& edge : map.edges) {
    EXPECT_LT(edge.a, edge.b);
    EXPECT_LE(edge.b.value, static_cast<int64_t>(map.planes.size()));
    EXPECT_NEAR(ComputeEigenvalues(edge.homology).scale, 1, 1e-6);
  }
}

TEST(BuildMap, HomographiesAreTheTrueOnes) {
  const MadeStage& stage = TheStage();
  const MapData& map = TheMap().map;
  std::vector<double> errors;
  for (const Plane& plane : map.planes) {
    const int reference_frame = map.keyframes[plane.reference.value - 1].frame;
    const auto& reference_pose = stage.walk.frames[reference_frame].world_from_camera;
    const cv::Mat ids = stage.renderer.Render(stage.world, reference_pose).plane_ids;
    std::map<int, int> counts;
    for (const PlaneFeature& f : plane.features) {
      const cv::Point at(static_cast<int>(std::lround(f.reference.x_px)),
                         static_cast<int>(std::lround(f.reference.y_px)));
      if (cv::Rect(0, 0, ids.cols, ids.rows).contains(at)) ++counts[ids.at<uint16_t>(at)];
    }
    const int truth = std::max_element(counts.begin(), counts.end(), [](auto& a, auto& b) {
                        return a.second < b.second;
                      })->first;
    for (const PlaneView& view : plane.views) {
      const int frame = map.keyframes[view.keyframe.value - 1].frame;
      const Eigen::Matrix3d to_keyframe =
          PlaneHomography(stage.world.PlaneById(truth), stage.renderer.camera(), reference_pose,
                          stage.walk.frames[frame].world_from_camera);
      for (const PlaneFeature& f : plane.features) {
        const Eigen::Vector2d x(f.reference.x_px, f.reference.y_px);
        const Eigen::Vector2d seen = Apply(to_keyframe, x);
        if (seen.x() < 0 || seen.y() < 0 || seen.x() >= 320 || seen.y() >= 240) continue;
        errors.push_back((Apply(view.reference_from_keyframe, seen) - x).norm());
      }
    }
  }
  ASSERT_GT(errors.size(), 100u);
  EXPECT_LT(Median(errors), 1.0);
}

TEST(BuildMap, IsTheSameOnAnyNumberOfThreads) { EXPECT_TRUE(Build(2).map == TheMap().map); }

TEST(BuildMap, IsWrittenAndReadBackSound) {
  const auto path = std::filesystem::path(testing::TempDir()) / "built.db";
  WriteMap(TheMap().map, path, {.overwrite = true});
  EXPECT_TRUE(CheckMap(path).empty());
  EXPECT_EQ(ReadMap(path).planes.size(), TheMap().map.planes.size());
  std::filesystem::remove(path);
}

TEST(BuildMap, AFrameBetweenKeyframesIsLocalizedBesideThem) {
  const MapData& map = TheMap().map;
  const auto index = MapIndex::Build(map);
  std::set<int> keyframes;
  for (const Keyframe& keyframe : map.keyframes) keyframes.insert(keyframe.frame);
  int asked = 0;
  int near = 0;
  for (int frame = 1; frame < 44; frame += 3) {
    if (keyframes.contains(frame)) continue;
    ++asked;
    const Answer answer = LocalizeImage(*index, TheStage().frames[frame], {});
    if (answer.verdict != Verdict::kLocalized) continue;
    near += std::abs(index->FindKeyframe(answer.planes.keyframe->id)->frame - frame) <= 12;
  }
  ASSERT_GT(asked, 5);
  EXPECT_GE(near, asked - 1);
}

// A frame of the stage as a camera with `factor` times the pixels a side would take it.
cv::Mat Enlarged(const cv::Mat& frame, int factor) {
  cv::Mat enlarged;
  cv::resize(frame, enlarged, {}, factor, factor, cv::INTER_CUBIC);
  return enlarged;
}

double WorstOf(const std::vector<double>& errors) {
  return errors.empty() ? 1e9 : *std::ranges::max_element(errors);
}

TEST(BuildMap, APhotoOfManyMorePixelsIsLocalizedAsItsSmallVersionIs) {
  const auto index = MapIndex::Build(TheMap().map);
  constexpr int kFactor = 8;  // 2560 x 1920
  for (int frame = 2; frame < 44; frame += 6) {
    LocalizeOptions options;
    options.explain = true;
    const Answer small = LocalizeImage(*index, TheStage().frames[frame], options);
    const Answer large =
        LocalizeImage(*index, Enlarged(TheStage().frames[frame], kFactor), options);
    ASSERT_EQ(small.verdict, Verdict::kLocalized);
    ASSERT_EQ(large.verdict, Verdict::kLocalized) << frame << ": " << large.message;
    EXPECT_GT(CountBestInliers(large.planes), 0.7 * CountBestInliers(small.planes));
    EXPECT_EQ(large.planes.explanation->width, kFactor * 320);
    // All of the answer is in the large photo's own pixels.
    for (const RecognisedPlane& plane : large.planes.recognised) {
      std::vector<double> errors;
      for (size_t i = 0; i < plane.query_points.size(); ++i) {
        const Eigen::Vector2d there = Apply(plane.reference_from_query, plane.query_points[i]);
        errors.push_back((there - plane.reference_points[i]).norm());
      }
      EXPECT_LT(WorstOf(errors), 10);
      EXPECT_EQ(plane.reference_from_query(2, 2), 1);
    }
    double right = 0;
    double bottom = 0;
    for (const Eigen::Vector2d& x : large.planes.epipolar->query_points) {
      right = std::max(right, x.x());
      bottom = std::max(bottom, x.y());
    }
    EXPECT_GT(right, kFactor * 200);
    EXPECT_LT(right, kFactor * 320);
    EXPECT_LT(bottom, kFactor * 240);
  }
}

TEST(BuildMap, AWalkOfManyMorePixelsGivesAMapInPixelsOfItsWorkingImages) {
  constexpr int kFactor = 4;
  MemorySequence sequence{.name = "large"};
  for (int i = 0; i < 45; ++i) {
    sequence.frames.emplace_back(FrameInfo{i, "frame " + std::to_string(i), i / 15.0},
                                 [=] { return Enlarged(TheStage().frames[i], kFactor); });
  }
  BuildOptions options;
  options.features.working_pixels = 320 * 240;
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::make_unique<MemorySource>(std::move(sequence)));
  const BuildResult large = BuildMap(sources, options, {});
  EXPECT_EQ(large.map.keyframes[0].width, 320);
  EXPECT_EQ(large.map.keyframes[0].height, 240);
  EXPECT_NEAR(static_cast<double>(large.map.keyframes.size()),
              static_cast<double>(TheMap().map.keyframes.size()), 2);
  EXPECT_GE(large.map.planes.size(), TheMap().map.planes.size() / 2);
  const auto index = MapIndex::Build(large.map);
  for (int frame = 2; frame < 44; frame += 6) {
    const cv::Mat& photo = TheStage().frames[frame];
    EXPECT_EQ(LocalizeImage(*index, photo, {}).verdict, Verdict::kLocalized) << frame;
    EXPECT_EQ(LocalizeImage(*index, Enlarged(photo, 3), {}).verdict, Verdict::kLocalized) << frame;
  }
}

TEST(BuildMap, UndecodableFramesAreNamedAndCounted) {
  const BuildResult result = Build(1, {3, 7}, 20);
  const PlaneReport& report = result.report.planes.value();
  EXPECT_EQ(report.frames, 20);
  EXPECT_EQ(report.skipped, 2);
  ASSERT_EQ(report.skipped_names.size(), 2u);
  EXPECT_EQ(report.skipped_names[0], "frame 3: made unreadable");
  EXPECT_EQ(result.map.sequences[0].skipped, 2);
}

TEST(BuildMap, NothingUsableIsAnError) {
  EXPECT_EQ(CodeOf([] { BuildMap({}, {}, {}); }), ErrorCode::kBadSource);
  EXPECT_EQ(CodeOf([] { Build(1, {0, 1, 2}, 3); }), ErrorCode::kBadSource);
}

// Walls without a feature give no keyframe, with poses as without.
TEST(BuildMap, PosesOfNoKeyframeAreNoError) {
  MemorySequence sequence{.name = "white", .camera = PinholeCamera(320, 240, 1.2)};
  for (int i = 0; i < 3; ++i) {
    sequence.frames.emplace_back(FrameInfo{i, std::to_string(i), {}},
                                 [] { return cv::Mat(240, 320, CV_8UC1, cv::Scalar(200)); });
  }
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::make_unique<MemorySource>(std::move(sequence)));
  GivenPoses poses;
  poses.of_image = [](const Sequence&, const FrameInfo&) { return Eigen::Isometry3d::Identity(); };
  const BuildResult result = BuildMap(sources, {}, {}, poses);
  EXPECT_TRUE(result.map.keyframes.empty());
  EXPECT_FALSE(result.map.poses);
}

TEST(BuildMap, StopsWhenAsked) {
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(OpenStage(10));
  EXPECT_EQ(
      CodeOf([&] { BuildMap(sources, {}, [](const BuildProgress& p) { return p.done < 3; }); }),
      ErrorCode::kInterrupted);
}

TEST(BuildMap, StopsBeforeAndAfterFusionWhenAsked) {
  for (int done : {0, 1}) {
    std::vector<std::unique_ptr<Source>> sources;
    sources.push_back(OpenStage(4));
    const auto stop = [&](const BuildProgress& p) { return p.stage != "fusion" || p.done != done; };
    EXPECT_EQ(CodeOf([&] { BuildMap(sources, {}, stop); }), ErrorCode::kInterrupted) << done;
  }
}

TEST(BuildMap, StopsWhileItLooksForRevisitsWhenAsked) {
  for (const char* stage : {"revisits", "links"}) {
    std::vector<std::unique_ptr<Source>> sources;
    sources.push_back(OpenStage(10));
    const auto stop = [&](const BuildProgress& p) { return p.stage != stage || p.done < 2; };
    EXPECT_EQ(CodeOf([&] { BuildMap(sources, {}, stop); }), ErrorCode::kInterrupted) << stage;
  }
}

TEST(BuildMap, LeavesPicturesOutWhenAsked) {
  BuildOptions options;
  options.images = false;
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(OpenStage(8));
  for (const Keyframe& keyframe : BuildMap(sources, options, {}).map.keyframes) {
    EXPECT_TRUE(keyframe.picture.empty());
  }
}

TEST(BuildMap, TwoSequencesDontTouch) {
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(OpenStage(12));
  sources.push_back(OpenStage(12));
  const BuildResult result = BuildMap(sources, {}, {});
  EXPECT_EQ(result.map.sequences.size(), 2u);
  EXPECT_EQ(result.report.planes->stretches, 2);
  // The second shows what the first one did: its planes were seen before.
  EXPECT_GT(result.report.planes->planes_fused, 0);
}

// The planes of a map taken apart: what the graph of all pairs finds, the votes propose too.
TEST(FusePlanes, ProposalsFindWhatTheExhaustiveSearchFinds) {
  MapData map = TheMap().map;
  std::vector<Plane> planes = map.planes;
  const size_t count = planes.size();
  for (size_t i = 0; i < count; ++i) {  // every plane seen again, by other ids
    Plane again = planes[i];
    again.id = PlaneId{static_cast<int64_t>(count + i) + 1};
    planes.push_back(again);
  }
  const PlaneLayerOptions options;
  const FusionResult proposed =
      FusePlanes(planes, map.edges, map.keyframes, FeatureType::kSift, options);
  const FusionResult exhaustive = FusePairs(
      planes, map.edges, map.keyframes, EveryPair(planes, map.edges), FeatureType::kSift, options);
  EXPECT_GE(proposed.fused, static_cast<int>(count));
  EXPECT_EQ(proposed.fused, exhaustive.fused);
  EXPECT_EQ(proposed.planes.size(), exhaustive.planes.size());
}

TEST(FusePlanes, DifferentPlanesStayApart) {
  const MapData& map = TheMap().map;
  const FusionResult result =
      FusePlanes(map.planes, map.edges, map.keyframes, FeatureType::kSift, {});
  EXPECT_EQ(result.fused, 0);
  EXPECT_EQ(result.planes.size(), map.planes.size());
}

TEST(FusePlanes, EdgesPassToTheOneThatStays) {
  const MapData& map = TheMap().map;
  ASSERT_FALSE(map.edges.empty());
  std::vector<Plane> planes = map.planes;
  std::vector<Edge> edges = {map.edges.front()};
  Plane again = planes[edges[0].a.value - 1];
  const PlaneId original = again.id;
  again.id = PlaneId{static_cast<int64_t>(planes.size()) + 1};
  planes.push_back(again);
  edges[0].a = edges[0].b;  // the edge leads from b to the plane seen again
  edges[0].b = again.id;
  std::erase_if(planes, [&](const Plane& plane) {
    return plane.id != original && plane.id != again.id && plane.id != edges[0].a;
  });
  const FusionResult result = FusePlanes(planes, edges, map.keyframes, FeatureType::kSift, {});
  EXPECT_EQ(result.fused, 1);
  ASSERT_EQ(result.edges.size(), 1u);
  EXPECT_EQ(std::minmax(original, edges[0].a), std::minmax(result.edges[0].a, result.edges[0].b));
}

}  // namespace
}  // namespace waystone
