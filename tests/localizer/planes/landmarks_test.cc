// SPDX-License-Identifier: Apache-2.0
// Places that landmarks alone show, in a map that has planes elsewhere.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/features/descriptor_codes.h"
#include "localizer/localizer.h"
#include "localizer/planes/decide.h"
#include "localizer/planes/locate.h"
#include "tests/localizer/planes/made_landmarks.h"

namespace waystone {
namespace {

using Eigen::Vector2d;

class LandmarkQueryTest : public testing::Test {
 protected:
  Answer Ask(const Features& query) const { return LocateByPlanes(*index_, query, {}, {}, true); }

  std::vector<Point> points_ = MakePoints(1);
  std::shared_ptr<const MapIndex> index_ = MapIndex::Build(MapWithLandmarks());
};

// The right half of a photo is white.
TEST_F(LandmarkQueryTest, WhatIsClippedIsNotMissing) {
  const Features whole = Look(points_, {0.1, 0, 0}, 0, 3);
  Features query{FeatureType::kSift, 640, 480, 640, 480, {}, Descriptors(128), {}};
  for (int i = 0; i < whole.size(); ++i) {
    if (whole.keypoints[i].x_px >= 320) continue;
    query.keypoints.push_back(whole.keypoints[i]);
    query.descriptors.Append(whole.descriptors.row(i));
  }
  const int keyframe = index_->IndexOf(KeyframeId{kLandmarkKeyframe});
  const auto missing = VerifyKeyframe(*index_, query, keyframe, {});
  for (int i = 0; i < kClippedCells * kClippedCells; ++i) {
    query.clipped.push_back(i % kClippedCells >= kClippedCells / 2);
  }
  const auto clipped = VerifyKeyframe(*index_, query, keyframe, {});
  EXPECT_GT(missing.distinct, 0);
  EXPECT_EQ(missing.distinct, clipped.distinct);
  EXPECT_LT(missing.distinct, 0.65 * missing.expected);
  EXPECT_GT(clipped.distinct, 0.9 * clipped.expected);
}

TEST_F(LandmarkQueryTest, LargeFeaturesAreFewIndependentOnes) {
  const auto look = [&](float scale_px) {
    Features query = Look(points_, {0.1, 0, 0}, 0, 3);
    for (Keypoint& keypoint : query.keypoints) keypoint.scale_px = scale_px;
    return query;
  };
  const int keyframe = index_->IndexOf(KeyframeId{kLandmarkKeyframe});
  const auto small = VerifyKeyframe(*index_, look(0.5F), keyframe, {});
  const auto large = VerifyKeyframe(*index_, look(40), keyframe, {});
  EXPECT_EQ(small.independent, small.distinct);
  EXPECT_EQ(small.independent_significance, small.significance);
  EXPECT_EQ(large.significance, small.significance);
  EXPECT_LT(large.independent, 10);
  EXPECT_LT(large.independent_significance, 0.1 * large.significance);
  EXPECT_LT(Ask(look(40)).probability, Ask(look(0.5F)).probability);
}

TEST_F(LandmarkQueryTest, APlaceWithoutPlanesIsLocalized) {
  for (uint64_t seed = 0; seed < 5; ++seed) {
    const Answer answer = Ask(Look(points_, {0.1, 0.05, 0.1}, 200, seed));
    ASSERT_EQ(answer.verdict, Verdict::kLocalized) << answer.message;
    EXPECT_EQ(answer.decided_by, DecidedBy::kEpipolarInliers);
    EXPECT_GE(answer.probability, 0.9);
    EXPECT_TRUE(answer.planes.recognised.empty());
    ASSERT_TRUE(answer.planes.keyframe && answer.planes.epipolar);
    EXPECT_GE(answer.planes.keyframe->id.value, kLandmarkKeyframe);
    EXPECT_EQ(answer.planes.epipolar->keyframe.id, answer.planes.keyframe->id);
    EXPECT_GE(answer.planes.epipolar->inliers, 60);
    EXPECT_EQ(CountBestInliers(answer.planes), answer.planes.epipolar->inliers);
  }
}

// Beside panoramas, in a map whose keyframes saw no plane at all.
TEST_F(LandmarkQueryTest, APhotoIsAskedOfLandmarksBesidePanoramas) {
  MapData map = MapWithLandmarks();
  map.planes.clear();
  map.edges.clear();
  map.appearance.emplace();
  const SignatureOptions& described = map.appearance->described;
  for (int i = 0; i < 2; ++i) {
    AppearanceNode node;
    node.id = AppearanceNodeId{i + 1};
    node.sequence = SequenceId{1};
    node.signature.magnitudes.setZero(described.rows, described.k1);
    node.signature.phases.setZero(described.rows, described.k2);
    map.appearance->nodes.push_back(node);
  }
  const auto index = MapIndex::Build(std::move(map));
  EXPECT_TRUE(index->HasKeyframeFeatures());
  const cv::Mat photo(480, 640, CV_8UC1, cv::Scalar(90));
  EXPECT_EQ(LocalizeImage(*index, photo, {}).decided_by, DecidedBy::kFeatures);
}

TEST_F(LandmarkQueryTest, TheAnswerShowsItsMatches) {
  const Answer answer = Ask(Look(points_, {0.1, 0, 0.1}, 100, 1));
  ASSERT_TRUE(answer.planes.epipolar && answer.planes.explanation);
  EXPECT_EQ(answer.planes.epipolar->query_points.size(),
            answer.planes.epipolar->keyframe_points.size());
  const std::vector<ExplainedKeyframe>& keyframes = answer.planes.explanation->keyframes;
  ASSERT_FALSE(keyframes.empty());
  EXPECT_EQ(keyframes.front().keyframe, answer.planes.epipolar->keyframe.id);
  EXPECT_EQ(keyframes.front().place, 0);
  EXPECT_EQ(keyframes.front().inliers, answer.planes.epipolar->inliers);
  EXPECT_GE(keyframes.front().expected, keyframes.front().inliers / 2);
}

TEST_F(LandmarkQueryTest, AnotherPlaceIsNotInTheMap) {
  for (uint64_t seed = 10; seed < 20; ++seed) {
    const Answer answer = Ask(Look(MakePoints(seed), {0, 0, 0}, 200, seed));
    EXPECT_EQ(answer.verdict, Verdict::kNotInMap) << seed;
    EXPECT_FALSE(answer.planes.keyframe);
  }
}

// A poster of the place that hangs elsewhere too: all that lies in one corner of the keyframe,
// among other things than there.
TEST_F(LandmarkQueryTest, AFewFeaturesInOneCornerAreNotThePlace) {
  std::vector<Point> poster;
  for (const Point& point : points_) {
    const Vector2d x = Project(point.x);
    if (x.x() > 420 && x.y() < 200) poster.push_back(point);
  }
  ASSERT_GE(poster.size(), 9u);
  for (uint64_t seed = 0; seed < 5; ++seed) {
    EXPECT_EQ(Ask(Look(poster, {0.02, 0, 0}, 300, seed)).verdict, Verdict::kNotInMap);
  }
}

TEST_F(LandmarkQueryTest, PlanesElsewhereAreFoundAsBefore) {
  const MapData map = MadeMap();
  const auto planes_alone = MapIndex::Build(map);
  const Features query = QueryOf(map, {1, 2}, PoseOf(1.5), 100, 3);
  const Answer with = Ask(query);
  const Answer without = LocateByPlanes(*planes_alone, query, {}, {}, true);
  ASSERT_EQ(without.verdict, Verdict::kLocalized);
  EXPECT_EQ(with.verdict, Verdict::kLocalized);
  EXPECT_EQ(with.planes.keyframe->id, without.planes.keyframe->id);
  EXPECT_EQ(with.decided_by, DecidedBy::kHomographyInliers);
  EXPECT_FALSE(without.planes.epipolar);
  EXPECT_TRUE(without.planes.explanation->keyframes.empty());
}

TEST_F(LandmarkQueryTest, KeyframesGetTheVotesOfTheirLandmarksAndPlanes) {
  const Shortlist of_landmarks = VoteForPlaces(*index_, Look(points_, {0.1, 0, 0}, 50, 1), {});
  ASSERT_GE(of_landmarks.keyframes.size(), 2u);
  for (int i = 0; i < 2; ++i) EXPECT_GE(of_landmarks.keyframes[i].keyframe, 6);
  const Shortlist of_planes =
      VoteForPlaces(*index_, QueryOf(MadeMap(), {4}, PoseOf(5.5), 10, 1), {});
  // Keyframes that saw several planes get more votes by chance, so the right ones needn't be first.
  EXPECT_TRUE(std::ranges::any_of(of_planes.keyframes, [](const ShortlistedKeyframe& candidate) {
    return candidate.keyframe == 4 || candidate.keyframe == 5;
  }));
}

TEST(Shortlist, ManyFeaturesThatResembleOneLandmarkDontOutweighSeveralLandmarks) {
  MapData map = MapWithLandmarks();
  const std::vector<Point> elsewhere = MakePoints(2);
  Keyframe keyframe = map.keyframes.back();
  keyframe.id = KeyframeId{kLandmarkKeyframe + 2};
  keyframe.stretch = 3;
  keyframe.landmarks = MakeLandmarks(Look(elsewhere, {0, 0, 0}, 0, 1));
  map.keyframes.push_back(keyframe);
  const std::vector<Point> points = MakePoints(1);
  Features query = Look({points.begin(), points.begin() + 15}, {0.1, 0, 0}, 0, 1);
  for (int i = 0; i < 60; ++i) {
    query.keypoints.push_back({10.f * i, 100, 8, 0});
    query.descriptors.Append(elsewhere.front().descriptor.data());
  }
  const Shortlist shortlist = VoteForPlaces(*MapIndex::Build(map), query, {});
  ASSERT_GE(shortlist.keyframes.size(), 2u);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(map.keyframes[shortlist.keyframes[i].keyframe].stretch, 2) << i;
  }
}

// A wall at the right, and a keyframe five times as far ahead as the wall is away.
TEST(CollectKeyframeFeatures, LeavesOutWhatIsBehindTheCamera) {
  MapData map = MadeMap();
  Plane& wall = map.planes[3];
  for (size_t i = 0; i < wall.features.size(); ++i) {
    const double depth = i % 2 == 0 ? 10 : 2;  // in the reference image, in distances of the wall
    const Vector2d x = Project({1, 0.1 * depth, depth});
    wall.features[i].reference.x_px = static_cast<float>(x.x());
    wall.features[i].reference.y_px = static_cast<float>(x.y());
  }
  Eigen::Matrix3d camera;
  camera << 500, 0, 319.5, 0, 500, 239.5, 0, 0, 1;
  Eigen::Matrix3d moved = Eigen::Matrix3d::Identity();
  moved(2, 0) = -5;  // X - t n' X / d
  const Eigen::Matrix3d keyframe_from_reference = camera * moved * camera.inverse();
  const KeyframeId ahead = map.keyframes[5].id;
  std::erase_if(wall.views, [&](const PlaneView& view) { return view.keyframe == ahead; });
  wall.views.push_back({ahead, keyframe_from_reference.inverse(), 20});
  const auto index = MapIndex::Build(map);
  EXPECT_EQ(CollectKeyframeFeatures(*index, 5).positions.size(), wall.features.size() / 2);
}

TEST(MapIndexLandmarks, TheirRowsComeAfterThePlanes) {
  const MapData map = MapWithLandmarks();
  const auto index = MapIndex::Build(map);
  EXPECT_TRUE(index->HasLandmarks());
  int row = 4 * kMapFeatures;
  for (int k = 6; k < 8; ++k) {
    const Landmarks& landmarks = map.keyframes[k].landmarks;
    EXPECT_EQ(index->LandmarkDescriptorsOf(k),
              DecodeDescriptors(landmarks.codes, FeatureType::kSift));
    for (int i = 0; i < landmarks.size(); ++i, ++row) {
      EXPECT_EQ(index->PlaneOfRow(row), -1);
      EXPECT_EQ(index->KeyframeOfRow(row), k);
    }
  }
  EXPECT_EQ(index->search().rows(), row);
  EXPECT_FALSE(MadeIndex()->HasLandmarks());
}

}  // namespace
}  // namespace waystone
