// SPDX-License-Identifier: Apache-2.0
// Places that landmarks alone show, in a map that has planes elsewhere.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/features/descriptor_codes.h"
#include "localizer/localizer.h"
#include "localizer/planes/decide.h"
#include "localizer/planes/locate.h"
#include "localizer/planes/sightings.h"
#include "localizer/planes/surroundings.h"
#include "localizer/verdict/keyframe_verdict.h"
#include "tests/localizer/made_map.h"

namespace waystone {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kPoints = 120;
constexpr int64_t kFirst = 7;  // keyframe of the place, of two

// As the builder has them: squares of normals, of length 256.
std::vector<uint8_t> MakeDescriptor(Random& random) {
  Eigen::VectorXd values(128);
  for (double& value : values) value = std::pow(random.Normal(), 2);
  values *= 256 / values.norm();
  std::vector<uint8_t> descriptor;
  for (const double value : values) {
    descriptor.push_back(static_cast<uint8_t>(std::min(std::lround(value), 127L)));
  }
  return descriptor;
}

struct Point {
  Vector3d x;  // in the first keyframe's camera
  std::vector<uint8_t> descriptor;
};

// Points at all depths, none of which lie on a plane.
std::vector<Point> MakePoints(uint64_t seed) {
  Random random(seed);
  std::vector<Point> points;
  for (int i = 0; i < kPoints; ++i) {
    const double z = random.Uniform(2, 8);
    points.push_back({{random.Uniform(-0.6, 0.6) * z, random.Uniform(-0.45, 0.45) * z, z},
                      MakeDescriptor(random)});
  }
  return points;
}

Vector2d Project(const Vector3d& x) { return 500 * x.hnormalized() + Vector2d(319.5, 239.5); }

bool IsSeen(const Vector2d& x) { return x.x() >= 0 && x.y() >= 0 && x.x() < 640 && x.y() < 480; }

// What the points give a camera that has moved by `shift`, noisy by 0.3 px, and `clutter`.
Features Look(const std::vector<Point>& points, const Vector3d& shift, int clutter, uint64_t seed) {
  Random random(5000 + seed);
  Features features{FeatureType::kSift, 640, 480, 640, 480, {}, Descriptors(128), {}};
  const auto add = [&](const Vector2d& x, const std::vector<uint8_t>& descriptor) {
    if (!IsSeen(x)) return;
    features.keypoints.push_back({static_cast<float>(x.x()), static_cast<float>(x.y()), 8, 0});
    features.descriptors.Append(descriptor.data());
  };
  for (const Point& point : points) {
    add(Project(point.x - shift) + 0.3 * Vector2d(random.Normal(), random.Normal()),
        point.descriptor);
  }
  for (int i = 0; i < clutter; ++i) {
    add({random.Uniform(0, 640), random.Uniform(0, 480)}, MakeDescriptor(random));
  }
  return features;
}

Landmarks MakeLandmarks(const Features& seen) {
  Landmarks landmarks;
  for (const Keypoint& keypoint : seen.keypoints) {
    landmarks.positions.push_back(EncodePosition(PositionOf(keypoint), 640, 480));
  }
  landmarks.codes = EncodeDescriptors(seen.descriptors, FeatureType::kSift);
  return landmarks;
}

// The made map, with a place of two keyframes that saw no plane.
MapData MapWithLandmarks() {
  MapData map = MadeMap();
  const std::vector<Point> points = MakePoints(1);
  for (int i = 0; i < 2; ++i) {
    Keyframe keyframe = map.keyframes.back();
    keyframe.id = KeyframeId{kFirst + i};
    keyframe.stretch = 2;
    keyframe.source = "landmarks/" + std::to_string(i);
    keyframe.landmarks = MakeLandmarks(Look(points, {0.3 * i, 0, 0}, 0, i));
    map.keyframes.push_back(keyframe);
  }
  return map;
}

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
  const int keyframe = index_->IndexOf(KeyframeId{kFirst});
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
  const int keyframe = index_->IndexOf(KeyframeId{kFirst});
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
    EXPECT_GE(answer.planes.keyframe->id.value, kFirst);
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
  keyframe.id = KeyframeId{kFirst + 2};
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

// Keyframes 5 and 6 saw plane 4, a poster that hangs in another place as well: keyframes 7 and 8 of
// a second sequence, with other things around it, and the planes of both are fused.
struct PosterInTwoPlaces {
  MapData map = MadeMap();
  std::vector<Point> around_first = MakePoints(21);
  std::vector<Point> around_second = MakePoints(22);

  explicit PosterInTwoPlaces(size_t in_first = 20, size_t in_second = 50) {
    around_first.resize(in_first);
    around_second.resize(in_second);
    map.sequences.push_back(map.sequences.back());
    map.sequences.back().id = SequenceId{2};
    map.sequences.back().name = "second";
    Plane& poster = map.planes[3];
    for (int i = 0; i < 2; ++i) {
      map.keyframes[4 + i].landmarks = MakeLandmarks(Look(around_first, {0, 0, 0}, 0, i));
      Keyframe keyframe = map.keyframes[4 + i];
      keyframe.id = KeyframeId{kFirst + i};
      keyframe.sequence = SequenceId{2};
      keyframe.stretch = 2;
      keyframe.landmarks = MakeLandmarks(Look(around_second, {0, 0, 0}, 0, i));
      map.keyframes.push_back(keyframe);
      PlaneView view = poster.views[i];
      view.keyframe = keyframe.id;
      poster.views.push_back(view);
    }
  }

  // The poster, as a photo between two keyframes of either place shows it, and points around it.
  Features Photo(const std::vector<Point>& around, uint64_t seed) const {
    Features photo = QueryOf(map, {4}, PoseOf(5.1), 50, seed);
    const Features more = Look(around, {0, 0, 0}, 0, seed);
    for (int i = 0; i < more.size(); ++i) {
      photo.keypoints.push_back(more.keypoints[i]);
      photo.descriptors.Append(more.descriptors.row(i));
    }
    return photo;
  }

  Answer Ask(const Features& photo) const {
    return LocateByPlanes(*MapIndex::Build(map), photo, {}, {}, true);
  }
};

VerifiedKeyframe MakeVerified(int keyframe, int distinct) {
  VerifiedKeyframe verified;
  verified.keyframe = keyframe;
  verified.matches = 80;
  verified.distinct = distinct;
  verified.expected = 100;
  verified.significance = 50;
  verified.independent_significance = 50;
  return verified;
}

TEST(PosterInTwoPlaces, WhatIsAroundItSaysInWhichOne) {
  const PosterInTwoPlaces more_in_first(50, 20);
  const PosterInTwoPlaces more_in_second(20, 50);
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    const Answer first = more_in_first.Ask(more_in_first.Photo(more_in_first.around_first, seed));
    ASSERT_EQ(first.verdict, Verdict::kLocalized) << first.message;
    EXPECT_LT(first.planes.keyframe->id.value, kFirst);
    const Answer second =
        more_in_second.Ask(more_in_second.Photo(more_in_second.around_second, seed));
    ASSERT_EQ(second.verdict, Verdict::kLocalized) << second.message;
    EXPECT_GE(second.planes.keyframe->id.value, kFirst);
  }
}

// A third visit that is near the first isn't a rival, but hides none either.
TEST(PosterInTwoPlaces, ARivalIsOneBehindAPlaceThatIsNear) {
  PosterInTwoPlaces made;
  const auto index = MapIndex::Build(made.map);
  std::vector<Place> places(3);
  const int keyframes[] = {4, 5, 6};
  for (int i = 0; i < 3; ++i) {
    places[i].keyframe = MakeVerified(keyframes[i], 40 - i);
    places[i].probability = 0.95;
  }
  const std::vector<const Place*> rivals = FindRivals(*index, places, {});
  ASSERT_EQ(rivals.size(), 1u);
  EXPECT_EQ(rivals[0]->keyframe->keyframe, 6);
  places[2].keyframe->distinct = 20;
  EXPECT_TRUE(FindRivals(*index, places, {}).empty());
}

// Each visit has the planes that were seen from near it, the poster both.
TEST(PosterInTwoPlaces, EachVisitHasItsOwnPlanes) {
  PosterInTwoPlaces made;
  // The poster is seen on with plane 3 in the first place, with plane 1 in the second.
  for (const int64_t keyframe : {5, 6}) {
    made.map.planes[2].views.push_back({KeyframeId{keyframe}, Eigen::Matrix3d::Identity(), 20});
  }
  made.map.planes[0].views.resize(1);
  for (const int64_t keyframe : {kFirst, kFirst + 1}) {
    made.map.planes[0].views.push_back({KeyframeId{keyframe}, Eigen::Matrix3d::Identity(), 20});
  }
  const auto index = MapIndex::Build(made.map);
  std::vector<Place> places(1);
  Features query{FeatureType::kSift, 640, 480, 640, 480, {}, Descriptors(128), {}};
  for (const auto& [plane, distinct] : {std::pair(3, 40), std::pair(2, 30), std::pair(0, 28)}) {
    VerifiedPlane verified;
    verified.plane = plane;
    verified.matches = 50;
    verified.distinct = distinct;
    for (int i = 0; i < distinct; ++i) {
      verified.inliers.push_back({query.size(), i, 0});
      query.keypoints.push_back({10, 10, 8, 0});
    }
    AddTo(*index, places.front(), verified);
  }
  JoinKeyframes(*index, query, {MakeVerified(4, 62), MakeVerified(6, 60)}, {}, places);
  ASSERT_EQ(places.size(), 2u);
  EXPECT_EQ(places[0].keyframe->keyframe, 4);
  EXPECT_EQ(places[0].evidence.inliers, 70);
  EXPECT_EQ(places[1].keyframe->keyframe, 6);
  EXPECT_EQ(places[1].evidence.inliers, 68);
}

// Two planes of a keyframe that contradict each other, and little of what it shows besides.
TEST(JoinKeyframes, WhatAKeyframeRefusesNoneOfItsPlanesAnswers) {
  const auto index = MapIndex::Build(MapWithLandmarks());
  std::vector<Place> places(2);
  for (const int plane : {0, 1}) {
    VerifiedPlane verified;
    verified.plane = plane;
    verified.matches = 50;
    verified.distinct = 40 - plane;
    for (int i = 0; i < verified.distinct; ++i) verified.inliers.push_back({i, i, 0});
    AddTo(*index, places[plane], verified);
    ASSERT_GE(places[plane].probability, 0.9);
  }
  Features query{FeatureType::kSift, 640, 480, 640, 480, {}, Descriptors(128), {}};
  for (int i = 0; i < 40; ++i) query.keypoints.push_back({10.0F * i, 5, 8, 0});
  VerifiedKeyframe verified = MakeVerified(1, 30);
  verified.expected = 1000;
  JoinKeyframes(*index, query, {verified}, {}, places);
  ASSERT_EQ(places.size(), 2u);
  EXPECT_LT(places[0].probability, 0.9);
  EXPECT_LT(places[1].probability, 0.9);
}

// A wall at the right, and a keyframe five times as far ahead as the wall is away.
// A place of one plane with so many inliers, wherever they are.
Place MakePlace(const MapIndex& index, int plane, int inliers) {
  VerifiedPlane verified;
  verified.plane = plane;
  verified.matches = inliers + 10;
  verified.distinct = inliers;
  for (int i = 0; i < inliers; ++i) verified.inliers.push_back({i, i, 0});
  Place place;
  AddTo(index, place, verified);
  return place;
}

// Nothing of the image fits any keyframe, but for what it shares with some planes.
TEST(VerifyKeyframes, NoPlaceThatItsKeyframeRefusesIsAnAnswer) {
  const auto index = MapIndex::Build(MapWithLandmarks());
  const Features query = Look({}, {0, 0, 0}, 100, 1);
  const std::vector<Place> alone{MakePlace(*index, 0, 40), MakePlace(*index, 3, 16)};
  std::vector<Place> places = alone;
  for (const Place& place : alone) ASSERT_GE(place.probability, 0.9);
  const std::vector<VerifiedKeyframe> verified = VerifyKeyframes(*index, query, {}, places, {});
  ASSERT_EQ(verified.size(), 2u) << "the second place comes first once the first one is refused";
  JoinKeyframes(*index, query, verified, {}, places);
  ASSERT_EQ(places.size(), 2u);
  for (const Place& place : places) {
    ASSERT_TRUE(place.keyframe);
    EXPECT_EQ(place.keyframe->distinct, 0);
    EXPECT_LT(place.probability, 0.5);
  }
}

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

TEST(PosterInTwoPlaces, AloneItIsAmbiguous) {
  const PosterInTwoPlaces made;
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    const Answer answer = made.Ask(made.Photo({}, seed));
    EXPECT_EQ(answer.verdict, Verdict::kAmbiguous);
    EXPECT_LT(answer.probability, 0.7) << "it may be the other one";
    EXPECT_GT(answer.probability, 0.3);
  }
}

TEST(PosterInTwoPlaces, LinkedKeyframesAreOfOnePlace) {
  PosterInTwoPlaces made;
  made.map.links = {{KeyframeId{6}, KeyframeId{8}}};
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    EXPECT_EQ(made.Ask(made.Photo({}, seed)).verdict, Verdict::kLocalized);
  }
}

TEST(KeyframesAreNear, WhereTwoPlanesWereSeenByBoth) {
  PosterInTwoPlaces made;
  EXPECT_TRUE(KeyframesAreNear(*MapIndex::Build(made.map), 4, 5));
  EXPECT_FALSE(KeyframesAreNear(*MapIndex::Build(made.map), 4, 6));
  EXPECT_FALSE(KeyframesNearThird(*MapIndex::Build(made.map), 4).contains(6));
  for (const int64_t keyframe : {5, 7}) {
    made.map.planes[0].views.push_back({KeyframeId{keyframe}, Eigen::Matrix3d::Identity(), 20});
  }
  const auto index = MapIndex::Build(made.map);
  EXPECT_TRUE(KeyframesAreNear(*index, 4, 6));
  EXPECT_TRUE(KeyframesAreNear(*index, 6, 4));
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

TEST(KeyframeVerdict, EveryKindOfEvidenceSpeaksForAPlace) {
  const double p = ComputeProbability({6, 3, 0.3, 0.2, 0.6});
  EXPECT_GT(ComputeProbability({7, 3, 0.3, 0.2, 0.6}), p);
  EXPECT_GT(ComputeProbability({6, 4, 0.3, 0.2, 0.6}), p);
  EXPECT_GT(ComputeProbability({6, 3, 0.4, 0.2, 0.6}), p);
  EXPECT_GT(ComputeProbability({6, 3, 0.3, 0.3, 0.6}), p);
  EXPECT_GT(ComputeProbability({6, 3, 0.3, 0.2, 0.7}), p);
}

TEST(KeyframeVerdict, NothingFoundIsNoPlace) { EXPECT_LT(ComputeProbability({}), 0.01); }

TEST(KeyframeVerdict, MoreInliersThanRuleOutChanceAreNoFurtherEvidence) {
  EXPECT_EQ(ComputeProbability({50, 50, 0.15, 0.1, 0.6}),
            ComputeProbability({500, 500, 0.15, 0.1, 0.6}));
}

TEST(KeyframeVerdict, WhatRandomMatchesGiveIsNoPlaceHoweverWellItFits) {
  const auto probability = [](double significance, double independent_significance) {
    return ComputeProbability({.significance = significance,
                               .independent_significance = independent_significance,
                               .found_share = 1,
                               .coverage = 1,
                               .inlier_share = 1});
  };
  EXPECT_LE(probability(0, 20), 0.5);  // one or more geometries of random matches
  EXPECT_LT(probability(2, 20), 0.9);
  EXPECT_GT(probability(3, 20), 0.9);
  EXPECT_GT(probability(20, 0), 0.9);
}

TEST(KeyframeVerdict, APosterIsNotAPlace) {
  EXPECT_LT(ComputeProbability({50, 20, 0.13, 0.2, 0.6}), 0.9);  // much of it, little around it
  EXPECT_LT(ComputeProbability({20, 12, 0.3, 0.08, 0.6}), 0.9);  // in a corner of the image
  EXPECT_LT(ComputeProbability({11, 0, 0.4, 0.08, 0.93}), 0.9);  // two corners of a room
  EXPECT_GE(ComputeProbability({20, 10, 0.5, 0.25, 0.7}), 0.9);
  EXPECT_GE(ComputeProbability({20, 12, 0.1, 0.4, 0.7}), 0.9);   // all over the image
  EXPECT_LT(ComputeProbability({0, 0, 0.08, 0.25, 0.45}), 0.1);  // chance
}

}  // namespace
}  // namespace waystone
