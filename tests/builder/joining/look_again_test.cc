// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/look_again.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "builder/joining/kept_looks.h"
#include "builder/joining/merge_maps.h"
#include "builder/joining/remove_keyframes.h"
#include "schema/sessions.h"
#include "tests/builder/joining/walked_maps.h"

namespace waystone {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr int kWidth = 320;

// Matches on a grid around (160, 120) that an affinity moves, but for those that `is_hole` leaves
// out.
template <class Move>
LocalMotion GridMoved(const Move& move, double left = 60, double right = 260) {
  std::vector<Vector2d> from;
  std::vector<Vector2d> to;
  for (double x = left; x <= right; x += 20) {
    for (double y = 40; y <= 200; y += 20) {
      from.emplace_back(x, y);
      to.push_back(move(from.back()));
    }
  }
  return {from, to, kWidth};
}

TEST(LocalMotion, PredictsWhatMovesWithWhatIsAround) {
  const Matrix2d turned{{0.9, -0.2}, {0.25, 1.1}};
  const auto move = [&](const Vector2d& x) -> Vector2d { return turned * x + Vector2d(5, -3); };
  const Vector2d x(151, 117);
  const auto there = GridMoved(move).Predict(x);
  ASSERT_TRUE(there);
  EXPECT_LT((*there - move(x)).norm(), 1e-9);
}

TEST(LocalMotion, PredictsNothingThatMatchesDoNotSurround) {
  const auto still = [](const Vector2d& x) { return x; };
  EXPECT_TRUE(GridMoved(still).Predict({70, 120}));
  EXPECT_FALSE(GridMoved(still).Predict({50, 120}));
  EXPECT_FALSE(GridMoved(still, 180, 260).Predict({160, 120}));
  EXPECT_FALSE(LocalMotion({}, {}, kWidth).Predict({160, 120}));
}

// A step of 40 px between two halves: something is in front of something else.
TEST(LocalMotion, PredictsNothingBesideAnEdgeInSpace) {
  const auto move = [](const Vector2d& x) -> Vector2d {
    return x + Vector2d(x.x() < 150 ? 0 : 40, 0);
  };
  EXPECT_FALSE(GridMoved(move).Predict({150, 120}));
  EXPECT_TRUE(GridMoved(move).Predict({230, 120}));
}

TEST(LocalMotion, PredictsNothingSeenFromMuchNearerFartherOrMoreObliquely) {
  const auto scaled = [](double x, double y) {
    return [x, y](const Vector2d& at) { return Vector2d(x * at.x(), y * at.y()); };
  };
  EXPECT_TRUE(GridMoved(scaled(1.8, 1.8)).Predict({160, 120}));
  EXPECT_FALSE(GridMoved(scaled(2.3, 2.3)).Predict({160, 120}));
  EXPECT_FALSE(GridMoved(scaled(0.4, 0.4)).Predict({160, 120}));
  EXPECT_FALSE(GridMoved(scaled(1, 2.5)).Predict({160, 120}));
  EXPECT_FALSE(GridMoved(scaled(1, -1)).Predict({160, 120}));
  EXPECT_FALSE(GridMoved(scaled(1, 0)).Predict({160, 120}));
}

// A walk that is the map's own finds all that it looks for.
class LookAgainTest : public testing::Test {
 protected:
  static std::vector<WalkImage> FeaturesOf(const MapData& map) {
    std::vector<WalkImage> features;
    for (const Keyframe& keyframe : map.keyframes) {
      features.push_back({keyframe.sequence, keyframe.frame, FeaturesOfFrames()[keyframe.frame]});
    }
    return features;
  }

  static const MapData& First() {
    static const MapData map = MapOfFrames(0, 20, "first");
    return map;
  }
  static const MapData& Second() {
    static const MapData map = MapOfFrames(4, 24, "second");
    return map;
  }

  // What the walk's images show of the map.
  LookCounts Look(const std::vector<WalkImage>& images, MapData& map) const {
    return LookAgain(AskMap(map, walk_, images, {}), walk_, images, map);
  }

  MapData map_ = First();
  const MapData& walk_ = Second();
};

TEST_F(LookAgainTest, FindsWhatIsThere) {
  const LookCounts counts = Look(FeaturesOf(walk_), map_);
  EXPECT_GT(counts.looked, 100);
  EXPECT_GT(counts.found, 0.9 * counts.looked);
  ASSERT_FALSE(map_.looks.planes.empty());
  for (const PlaneLooks& row : map_.looks.planes) EXPECT_EQ(row.sequence, SequenceId{2});
}

TEST_F(LookAgainTest, CountsNothingOfAnotherBuildingOrInTheDark) {
  const MapData elsewhere = MapOfAnotherBuilding();
  std::vector<WalkImage> features = FeaturesOf(walk_);
  for (WalkImage& one : features) {
    one.features.keypoints.clear();
    one.features.descriptors = Descriptors(DescriptorBytes(FeatureType::kSift));
  }
  EXPECT_EQ(Look(features, map_).looked, 0);
  EXPECT_EQ(Look({}, map_).looked, 0);
  MapData other = elsewhere;
  EXPECT_EQ(Look(FeaturesOf(walk_), other).looked, 0);
  EXPECT_TRUE(map_.looks.empty());
  EXPECT_TRUE(other.looks.empty());
}

// A map with another sequence of one keyframe, which sees the planes of the map's middle one beside
// landmarks of its own, and is linked with all others.
MapData WithLookAlike(MapData map) {
  const Keyframe middle = map.keyframes[map.keyframes.size() / 2];
  map.sequences.push_back(map.sequences.front());
  map.sequences.back().id = SequenceId{2};
  Keyframe like = middle;
  like.id = KeyframeId{map.keyframes.back().id.value + 1};
  like.sequence = SequenceId{2};
  like.stretch = map.keyframes.back().stretch + 1;
  std::vector<uint8_t> codes = middle.landmarks.codes.data();
  std::ranges::reverse(codes);
  like.landmarks.codes = Descriptors(middle.landmarks.codes.bytes(), std::move(codes));
  for (Plane& plane : map.planes) {
    const auto view = std::ranges::find(plane.views, middle.id, &PlaneView::keyframe);
    if (view == plane.views.end()) continue;
    PlaneView again = *view;
    again.keyframe = like.id;
    plane.views.push_back(again);
  }
  for (const Keyframe& keyframe : map.keyframes) map.links.push_back({keyframe.id, like.id});
  map.keyframes.push_back(like);
  return map;
}

// A link within a session may join what only looks alike: that landmarks of the one aren't seen at
// the other doesn't say that they are gone.
TEST_F(LookAgainTest, FollowsLinksBetweenSessionsOnly) {
  const auto is_looked_for = [&](MapData map) {
    const KeyframeId like = map.keyframes.back().id;
    EXPECT_GT(Look(FeaturesOf(walk_), map).looked, 100);
    return std::ranges::count(map.looks.landmarks, like, &LandmarkLooks::keyframe) > 0;
  };
  MapData map = WithLookAlike(First());
  ASSERT_GT(map.keyframes.back().landmarks.size(), 0);
  EXPECT_FALSE(is_looked_for(map));
  map.info.options_json = WithSessions(
      map.info.options_json,
      {{"first", "waystone", "", {SequenceId{1}}}, {"second", "waystone", "", {SequenceId{2}}}});
  ASSERT_EQ(SessionsOf(map).size(), 2u);
  EXPECT_TRUE(is_looked_for(map));
}

// Keyframes whose images are at hand are recognised by these, so that they need no picture.
TEST_F(LookAgainTest, RecognisesKeyframesByTheirImages) {
  MapData blind = walk_;
  for (Keyframe& keyframe : blind.keyframes) keyframe.picture.clear();
  EXPECT_EQ(AddToMap(map_, blind, {}).report.keyframes_recognised, 0);
  const int seen = AddToMap(map_, blind, {}, FeaturesOf(blind)).report.keyframes_recognised;
  EXPECT_GE(seen, AddToMap(map_, walk_, {}).report.keyframes_recognised);
  EXPECT_GT(seen, 0);
}

TEST_F(LookAgainTest, IsKeptByWhatChangesTheMap) {
  const MapData grown = AddToMap(map_, walk_, {}, FeaturesOf(walk_)).map;
  ASSERT_FALSE(grown.looks.empty());
  EXPECT_EQ(WrittenAndRead(grown).looks, grown.looks);
  // Joined to another map, with other ids.
  const MapData third = MapOfFrames(30, 40, "third");
  const MapData joined = MergeMaps({WrittenAndRead(grown), third}, "all", {}).map;
  EXPECT_EQ(joined.looks.planes.size(), grown.looks.planes.size());
  EXPECT_EQ(joined.looks.landmarks.size(), grown.looks.landmarks.size());
  WrittenAndRead(joined);
  // Without a keyframe, and without the session that looked.
  const MapData pared = RemoveFromMap(grown, {{KeyframeId{1}}, {}}, {}).map;
  EXPECT_FALSE(pared.looks.empty());
  WrittenAndRead(pared);
  std::set<KeyframeId> second;
  for (const Keyframe& keyframe : grown.keyframes) {
    if (keyframe.sequence == SequenceId{2}) second.insert(keyframe.id);
  }
  const MapData alone = RemoveFromMap(grown, {second, {}}, {}).map;
  EXPECT_TRUE(alone.looks.empty());
}

// Counts follow their features, whatever their order and whatever is left of them.
TEST(LooksBefore, KnowsFeaturesByTheirDescriptors) {
  MapData map = MapOfFrames(0, 8, "first");
  Plane& plane = map.planes.front();
  const size_t count = plane.features.size();
  PlaneLooks row{plane.id, map.sequences.front().id, std::vector<FeatureLooks>(count)};
  for (size_t f = 0; f < count; ++f) row.features[f] = {static_cast<uint8_t>(f % 200 + 1), 1};
  map.looks.planes = {row};
  const LooksBefore before(map);
  plane.features.erase(plane.features.begin());
  const auto bytes = static_cast<std::ptrdiff_t>(plane.descriptors.bytes());
  const std::vector<uint8_t>& all = plane.descriptors.data();
  plane.descriptors = Descriptors(plane.descriptors.bytes(), {all.begin() + bytes, all.end()});
  before.KeepLooks(map);
  ASSERT_EQ(map.looks.planes.size(), 1u);
  row.features.erase(row.features.begin());
  EXPECT_EQ(map.looks.planes.front(), row);
}

}  // namespace
}  // namespace waystone
