// SPDX-License-Identifier: Apache-2.0
#include "localizer/planes/explain.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "localizer/localizer.h"
#include "tests/localizer/made_map.h"

namespace waystone {
namespace {

class ExplainTest : public testing::Test {
 protected:
  Explanation Ask(const Features& query, LocalizeOptions options = {}) {
    options.explain = true;
    answer_ = LocalizeFeatures(*index_, query, options);
    EXPECT_TRUE(answer_.planes.explanation.has_value());
    return answer_.planes.explanation.value_or(Explanation{});
  }

  MapData map_ = MadeMap();
  std::shared_ptr<const MapIndex> index_ = MapIndex::Build(map_);
  Answer answer_;
};

TEST_F(ExplainTest, NothingUnlessAsked) {
  const Features query = QueryOf(map_, {1, 2}, PoseOf(2), 0, 1);
  EXPECT_FALSE(LocalizeFeatures(*index_, query, {}).planes.explanation.has_value());
}

TEST_F(ExplainTest, AgreesWithTheAnswer) {
  const Features query = QueryOf(map_, {1, 2}, PoseOf(2), 0, 1);
  const Explanation why = Ask(query);
  EXPECT_EQ(answer_.verdict, Verdict::kLocalized);
  EXPECT_EQ(why.width, 640);
  EXPECT_EQ(why.features, query.size());
  ASSERT_FALSE(why.places.empty());
  EXPECT_EQ(why.places[0].nearest, answer_.planes.keyframe->id);
  EXPECT_EQ(why.places[0].probability, answer_.probability);
  EXPECT_EQ(why.places[0].planes.size(), answer_.planes.recognised.size());
  for (const RecognisedPlane& plane : answer_.planes.recognised) {
    const auto it = std::find_if(why.candidates.begin(), why.candidates.end(),
                                 [&](const auto& c) { return c.plane == plane.id; });
    ASSERT_NE(it, why.candidates.end());
    EXPECT_EQ(it->stopped_by, Gate::kPassed);
    EXPECT_EQ(it->place, 0);
    EXPECT_EQ(it->query_points, plane.query_points);
    EXPECT_EQ(it->reference_points, plane.reference_points);
    EXPECT_EQ(it->reference, plane.reference.id);
  }
}

TEST_F(ExplainTest, NamesTheFirstGateThatStopped) {
  const Features query = QueryOf(map_, {1, 2}, PoseOf(2), 300, 1);
  LocalizeOptions options;
  options.planes.min_votes = 1;
  options.planes.gates.min_inliers = 1000;
  for (const ExplainedCandidate& c : Ask(query, options).candidates) {
    EXPECT_TRUE(c.stopped_by == Gate::kMinInliers || c.stopped_by == Gate::kNoHomography);
    EXPECT_EQ(c.place, -1);
  }
  options.planes.gates.min_inliers = 8;
  options.planes.gates.min_inlier_share = 1;
  const Explanation why = Ask(query, options);
  EXPECT_TRUE(std::any_of(why.candidates.begin(), why.candidates.end(),
                          [](const auto& c) { return c.stopped_by == Gate::kMinInlierShare; }));
}

TEST_F(ExplainTest, SaysWhatWasNotTriedOnceSettled) {
  // Two walls of the first surrounding; plane 4 is elsewhere and gets stray votes.
  const Features query = QueryOf(map_, {1, 2}, PoseOf(2), 0, 1);
  LocalizeOptions options;
  options.planes.min_votes = 1;
  options.planes.votes_per_feature = 2;
  options.planes.settled_inliers = 10;
  options.planes.settled_share = 0.7;
  const Explanation why = Ask(query, options);
  const auto it = std::find_if(why.candidates.begin(), why.candidates.end(),
                               [](const auto& c) { return c.plane == PlaneId{4}; });
  ASSERT_NE(it, why.candidates.end());
  EXPECT_EQ(it->matches, 0);
  EXPECT_EQ(it->stopped_by, Gate::kSettled);
  options.planes.settled_share = 0;
  options.planes.settled_inliers = 1'000'000;
  for (const ExplainedCandidate& c : Ask(query, options).candidates) {
    EXPECT_NE(c.stopped_by, Gate::kSettled) << c.plane.value;
  }
}

}  // namespace
}  // namespace waystone
