// SPDX-License-Identifier: Apache-2.0
#include "localizer/planes/decide.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "localizer/planes/shortlist.h"
#include "localizer/planes/verify.h"
#include "tests/localizer/made_map.h"

namespace waystone {
namespace {

VerifiedPlane Verified(const MapIndex& index, const Features& query, int plane) {
  const auto verified = VerifyPlane(index, PackedFeatures(query), plane, {});
  EXPECT_TRUE(verified.has_value()) << plane;
  return verified.value_or(VerifiedPlane{});
}

TEST(ShortlistPlanes, MostVotedFirstAndOnlyWithEnoughVotes) {
  const MapData map = MadeMap();
  const auto index = MapIndex::Build(map);
  const Features query = QueryOf(map, {1, 2}, PoseOf(2), 0, 1);
  PlaneQueryOptions options;
  options.votes_per_feature = 1;
  const std::vector<ShortlistedPlane> planes = ShortlistPlanes(*index, query, options);
  ASSERT_EQ(planes.size(), 2u);
  EXPECT_GE(planes[0].votes, planes[1].votes);
  EXPECT_EQ(planes[0].votes + planes[1].votes, query.size()) << "one vote a feature";
  options.min_votes = planes[1].votes + 1;
  const bool tie = planes[0].votes == planes[1].votes;
  EXPECT_EQ(ShortlistPlanes(*index, query, options).size(), tie ? 0u : 1u);
}

TEST(ShortlistPlanes, AFeatureVotesOnceForAPlane) {
  const MapData map = MadeMap();
  const auto index = MapIndex::Build(map);
  const Features query = QueryOf(map, {1}, PoseOf(1), 0, 2);
  PlaneQueryOptions options;
  options.votes_per_feature = 50;
  options.min_votes = 1;
  for (const ShortlistedPlane& plane : ShortlistPlanes(*index, query, options)) {
    EXPECT_LE(plane.votes, query.size());
  }
}

TEST(ShortlistPlanes, MaxCandidatesBoundsIt) {
  const MapData map = MadeMap();
  const auto index = MapIndex::Build(map);
  PlaneQueryOptions options;
  options.min_votes = 1;
  const Features query = QueryOf(map, {2}, PoseOf(2), 300, 3);
  EXPECT_EQ(ShortlistPlanes(*index, query, options).size(), 4u);
  options.max_candidates = 1;
  const std::vector<ShortlistedPlane> one = ShortlistPlanes(*index, query, options);
  ASSERT_EQ(one.size(), 1u);
}

TEST(VerifyPlane, AcceptsThePlaneThatIsThereAndNoOther) {
  const MapData map = MadeMap();
  const auto index = MapIndex::Build(map);
  const Features query = QueryOf(map, {2}, PoseOf(2.5), 200, 4);
  for (int plane = 0; plane < 4; ++plane) {
    const auto verified = VerifyPlane(*index, PackedFeatures(query), plane, {});
    const bool accepted = verified && verified->accepted;
    EXPECT_EQ(accepted, plane == 1) << plane;
    if (!verified) continue;
    EXPECT_LE(verified->distinct, static_cast<int>(verified->inliers.size()));
    EXPECT_LE(static_cast<int>(verified->inliers.size()), verified->matches);
  }
}

TEST(VerifyPlane, RefusesAScaleBeyondTheGate) {
  const MapData map = MadeMap();
  const auto index = MapIndex::Build(map);
  Features query = QueryOf(map, {1}, PoseOf(1), 0, 5);
  for (Keypoint& keypoint : query.keypoints) {  // the wall, three times as large
    keypoint.x_px *= 3;
    keypoint.y_px *= 3;
  }
  PlaneQueryOptions options;
  EXPECT_TRUE(VerifyPlane(*index, PackedFeatures(query), 0, options)->accepted);
  options.gates.max_scale = 2.5;
  EXPECT_FALSE(VerifyPlane(*index, PackedFeatures(query), 0, options)->accepted);
}

TEST(PlanesAgree, TwoPlanesSeenFromOnePlaceDoAndFromTwoPlacesDoNot) {
  const MapData map = MadeMap();
  const auto index = MapIndex::Build(map);
  int agree = 0;
  int disagree = 0;
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const Features query = QueryOf(map, {1, 2}, PoseOf(2.3), 0, seed);
    const VerifiedPlane m = Verified(*index, query, 0);
    agree += PlanesAgree(*index, m, Verified(*index, query, 1), {}) == true;
    MadePose elsewhere = PoseOf(2.3);
    elsewhere.t += Eigen::Vector3d(0.3, 0.5, -0.4);
    const Features other = QueryOf(map, {2}, elsewhere, 0, seed);
    disagree += PlanesAgree(*index, m, Verified(*index, other, 1), {}) == false;
  }
  EXPECT_GE(agree, 19) << "of 20";
  EXPECT_GE(disagree, 18) << "of 20";
}

TEST(PlanesAgree, NothingIsSaidOfPlanesThatNoKeyframeSawTogether) {
  const MapData map = MadeMap();
  const auto index = MapIndex::Build(map);
  const VerifiedPlane m = Verified(*index, QueryOf(map, {1}, PoseOf(2), 0, 6), 0);
  const VerifiedPlane n = Verified(*index, QueryOf(map, {4}, PoseOf(5.5), 0, 6), 3);
  EXPECT_EQ(PlanesAgree(*index, m, n, {}), std::nullopt);
}

TEST(GroupPlaces, PlanesOfOneSurroundingMakeOnePlace) {
  const MapData map = MadeMap();
  const auto index = MapIndex::Build(map);
  const Features query = QueryOf(map, {1, 2}, PoseOf(2), 0, 7);
  const VerifiedPlane wall = Verified(*index, query, 0);
  const VerifiedPlane right = Verified(*index, query, 1);
  const VerifiedPlane far = Verified(*index, QueryOf(map, {4}, PoseOf(5.5), 0, 7), 3);
  const std::vector<Place> places = GroupPlaces(*index, {far, wall, right}, {});
  ASSERT_EQ(places.size(), 2u);
  EXPECT_EQ(places[0].planes.size(), 2u);
  EXPECT_EQ(places[0].evidence.inliers, wall.distinct + right.distinct);
  for (const VerifiedPlane& plane : {wall, right}) {
    EXPECT_GE(places[0].probability, GroupPlaces(*index, {plane}, {})[0].probability);
  }
  EXPECT_EQ(places[1].planes.size(), 1u);
  EXPECT_EQ(places[1].planes[0].plane, 3);
  const std::vector<Place> apart{places[1], places[0]};
  EXPECT_EQ(FindRivals(*index, apart, {}).size(), 1u);
  const std::vector<Place> one{places[0], places[0]};
  EXPECT_TRUE(FindRivals(*index, one, {}).empty());
}

TEST(FindRivals, NotAPlaceThatWasPassedJustBeforeOrAfter) {
  MapData map = MadeMap();
  for (size_t k = 0; k < map.keyframes.size(); ++k) {
    map.keyframes[k].stretch = static_cast<int>(k);
  }
  const auto rivals = [&](int a, int b) {
    std::vector<Place> places(2);
    for (int i = 0; i < 2; ++i) {
      places[i].keyframe.emplace().keyframe = i == 0 ? a : b;
      places[i].keyframe->distinct = 40;
      places[i].probability = 0.95;
    }
    return FindRivals(*MapIndex::Build(map), places, {}).size();
  };
  EXPECT_EQ(rivals(0, 4), 0u);
  EXPECT_EQ(rivals(0, 5), 1u);
  map.sequences.push_back(map.sequences.front());
  map.sequences.back().id.value = 2;
  for (size_t k = 4; k < map.keyframes.size(); ++k) map.keyframes[k].sequence.value = 2;
  EXPECT_EQ(rivals(0, 4), 1u);
}

// Where planes overlap, as a plane and the one with a newer reference image do.
TEST(GroupPlaces, AFeatureThatTwoPlanesHaveCountsOnce) {
  const MapData map = MadeMap();
  const auto index = MapIndex::Build(map);
  const VerifiedPlane wall = Verified(*index, QueryOf(map, {1}, PoseOf(2), 0, 7), 0);
  VerifiedPlane same = wall;
  same.plane = 1;
  Place place;
  AddTo(*index, place, wall);
  AddTo(*index, place, same);
  EXPECT_EQ(place.planes.size(), 2u);
  EXPECT_EQ(place.evidence.inliers, wall.distinct);
}

TEST(GroupPlaces, OfNothingIsNothing) { EXPECT_TRUE(GroupPlaces(*MadeIndex(), {}, {}).empty()); }

}  // namespace
}  // namespace waystone
