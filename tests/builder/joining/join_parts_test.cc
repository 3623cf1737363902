// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/join_parts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <vector>

#include "builder/calibration/rendered_negatives.h"
#include "schema/sessions.h"
#include "tests/builder/joining/walked_maps.h"

namespace waystone {
namespace {

// The made walk cut as jobs cut one: ten frames in common.
const std::vector<MapData>& WalkInParts() {
  static const std::vector<MapData> parts{MapOfFrames(0, 21, "lab-1"), MapOfFrames(12, 33, "lab-2"),
                                          MapOfFrames(24, 44, "lab-3")};
  return parts;
}
const MapData& JoinedWalk() {
  static const MapData joined = JoinParts(WalkInParts(), "lab", {}).map;
  return joined;
}

TEST(JoinParts, AnswersAsTheMapOfTheWholeDoes) {
  const auto whole = MapIndex::Build(TheMap().map);
  EXPECT_EQ(JoinedWalk().info.name, "lab");
  EXPECT_EQ(FindParts(JoinedWalk()).size(), 1u);
  const auto joined = MapIndex::Build(JoinedWalk());
  std::vector<Features> queries = FeaturesOfFrames();
  const size_t inside = queries.size();
  for (Features& outside : CachedNegatives(15, FeatureOptions{})) {
    queries.push_back(std::move(outside));
  }
  int same = 0;
  for (size_t i = 0; i < queries.size(); ++i) {
    const Verdict expected = LocalizeFeatures(*whole, queries[i], {}).verdict;
    const Answer answer = LocalizeFeatures(*joined, queries[i], {});
    same += answer.verdict == expected;
    if (answer.verdict != Verdict::kLocalized) continue;
    EXPECT_LT(i, inside) << "another building";
  }
  EXPECT_GE(same, std::floor(0.98 * static_cast<double>(queries.size())));
}

TEST(JoinParts, IsTheSameEachTime) {
  EXPECT_TRUE(JoinParts(WalkInParts(), "lab", {}).map == JoinedWalk());
}

// As where the camera stood still at the end of the walk.
TEST(JoinParts, LeavesOutAPartThatShowsNothingElse) {
  const MapData& whole = WalkInParts().front();
  const MapData known = MapOfFrames(0, whole.keyframes[2].frame, "lab-2");
  const MapData map = JoinParts({whole, known}, "lab", {}).map;
  EXPECT_EQ(map.info.name, "lab");
  EXPECT_EQ(map.keyframes.size(), whole.keyframes.size());
  EXPECT_EQ(map.planes, whole.planes);
}

}  // namespace
}  // namespace waystone
