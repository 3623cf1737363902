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
std::vector<MapData> Parts() {
  return {MapOfFrames(0, 21, "lab-1"), MapOfFrames(12, 33, "lab-2"), MapOfFrames(24, 44, "lab-3")};
}

TEST(JoinParts, AnswersAsTheMapOfTheWholeDoes) {
  const auto whole = MapIndex::Build(TheMap().map);
  JoinResult result = JoinParts(Parts(), "lab", {});
  EXPECT_EQ(result.map.info.name, "lab");
  EXPECT_EQ(FindParts(result.map).size(), 1u);
  const auto joined = MapIndex::Build(std::move(result.map));
  std::vector<Features> queries = FeaturesOfFrames();
  const size_t inside = queries.size();
  for (Features& outside : RenderedNegatives(15, FeatureOptions{})) {
    queries.push_back(std::move(outside));
  }
  int same = 0;
  for (size_t i = 0; i < queries.size(); ++i) {
    const Verdict expected = LocalizeFeatures(*whole, queries[i], {}).verdict;
    const Answer answer = LocalizeFeatures(*joined, queries[i], {});
    same += answer.verdict == expected;
    if (answer.verdict == Verdict::kLocalized) EXPECT_LT(i, inside) << "another building";
  }
  EXPECT_GE(same, std::floor(0.98 * static_cast<double>(queries.size())));
}

TEST(JoinParts, IsTheSameEachTime) {
  EXPECT_TRUE(JoinParts(Parts(), "lab", {}).map == JoinParts(Parts(), "lab", {}).map);
}

// As where the camera stood still at the end of the walk.
TEST(JoinParts, LeavesOutAPartThatShowsNothingElse) {
  const MapData whole = MapOfFrames(0, 21, "lab-1");
  const MapData end = MapOfFrames(0, 12, "lab-2");
  const MapData map = JoinParts({whole, end}, "lab", {}).map;
  EXPECT_EQ(map.info.name, "lab");
  EXPECT_EQ(map.keyframes.size(), whole.keyframes.size());
  EXPECT_EQ(map.planes, whole.planes);
}

}  // namespace
}  // namespace waystone
