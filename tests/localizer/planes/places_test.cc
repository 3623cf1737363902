// SPDX-License-Identifier: Apache-2.0
// Places that share a poster, and what keyframes say of them.
#include <gtest/gtest.h>

#include "localizer/planes/decide.h"
#include "localizer/planes/locate.h"
#include "localizer/planes/sightings.h"
#include "localizer/planes/surroundings.h"
#include "tests/localizer/planes/made_landmarks.h"

namespace waystone {
namespace {

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
      keyframe.id = KeyframeId{kLandmarkKeyframe + i};
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

TEST(PosterInTwoPlaces, WhatIsAroundItSaysInWhichOne) {
  const PosterInTwoPlaces more_in_first(50, 20);
  const PosterInTwoPlaces more_in_second(20, 50);
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    const Answer first = more_in_first.Ask(more_in_first.Photo(more_in_first.around_first, seed));
    ASSERT_EQ(first.verdict, Verdict::kLocalized) << first.message;
    EXPECT_LT(first.planes.keyframe->id.value, kLandmarkKeyframe);
    const Answer second =
        more_in_second.Ask(more_in_second.Photo(more_in_second.around_second, seed));
    ASSERT_EQ(second.verdict, Verdict::kLocalized) << second.message;
    EXPECT_GE(second.planes.keyframe->id.value, kLandmarkKeyframe);
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
  places[2].probability = 0.1;
  EXPECT_TRUE(FindRivals(*index, places, {}).empty());
}

// The query is at one of the places, or at none: the odds of both count.
TEST(PosterInTwoPlaces, ARivalCountsByHowLikelyItIs) {
  const PosterInTwoPlaces made;
  const auto index = MapIndex::Build(made.map);
  const Features query{FeatureType::kSift, 640, 480, 640, 480, {}, Descriptors(128), {}};
  std::vector<Place> places(2);
  places[0].keyframe = MakeVerified(4, 40);
  places[1].keyframe = MakeVerified(6, 10);
  const auto ask = [&](double best, double rival) {
    places[0].probability = best;
    places[1].probability = rival;
    return Decide(*index, query, 1, {}, places, {});
  };
  const Answer clear = ask(0.99, 0.5);
  EXPECT_EQ(clear.verdict, Verdict::kLocalized);
  EXPECT_NEAR(clear.probability, 99.0 / (1 + 99 + 1), 1e-6);
  EXPECT_EQ(clear.planes.keyframe->id, KeyframeId{5});
  EXPECT_EQ(clear.planes.runner_up->keyframe.id, KeyframeId{7});
  EXPECT_TRUE(clear.planes.places.empty());
  EXPECT_EQ(ask(0.92, 0.5).verdict, Verdict::kAmbiguous);
  const Answer even = ask(0.99, 0.99);
  EXPECT_EQ(even.verdict, Verdict::kAmbiguous);
  EXPECT_LT(even.probability, 0.5);
  EXPECT_EQ(even.planes.places.size(), 2u);
}

// What planes give alone doesn't count what is missing.
TEST(Decide, PlacesOfPlanesAloneThatLookAlikeAreAmbiguous) {
  const auto index = MapIndex::Build(MadeMap());
  Features query{FeatureType::kSift, 640, 480, 640, 480, {}, Descriptors(128), {}};
  for (int i = 0; i < 60; ++i) query.keypoints.push_back({10.0F * i, 5, 8, 0});
  std::vector<Place> places{MakePlace(*index, 0, 50), MakePlace(*index, 3, 50)};
  places[0].probability = 0.999;
  places[1].probability = 0.5;
  for (Place& place : places) {
    place.planes.front().reference_from_query.b_from_a = Eigen::Matrix3d::Identity();
  }
  EXPECT_EQ(Decide(*index, query, 2, {}, places, {}).verdict, Verdict::kAmbiguous);
}

// Each visit has the planes that were seen from near it, the poster both.
TEST(PosterInTwoPlaces, EachVisitHasItsOwnPlanes) {
  PosterInTwoPlaces made;
  // The poster is seen on with plane 3 in the first place, with plane 1 in the second.
  for (const int64_t keyframe : {5, 6}) {
    made.map.planes[2].views.push_back({KeyframeId{keyframe}, Eigen::Matrix3d::Identity(), 20});
  }
  made.map.planes[0].views.resize(1);
  for (const int64_t keyframe : {kLandmarkKeyframe, kLandmarkKeyframe + 1}) {
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

}  // namespace
}  // namespace waystone
