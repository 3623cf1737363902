// SPDX-License-Identifier: Apache-2.0
#include "quality/evaluation.h"

#include <gtest/gtest.h>

#include "tests/localizer/made_map.h"
#include "world/walk.h"

namespace waystone {
namespace {

// In the made map keyframes 1 to 4 saw plane 2, and 5 and 6 are elsewhere.
class EvaluationTest : public testing::Test {
 protected:
  static ScoredQuery Query(const std::vector<int>& truth, Verdict verdict, int place,
                           double probability) {
    ScoredQuery query;
    for (const int id : truth) query.truth.push_back(PlaceIdOf(KeyframeId{id}));
    query.answer.verdict = verdict;
    query.answer.probability = probability;
    const KeyframeRef ref{KeyframeId{place}, "walk", "", std::nullopt};
    if (verdict == Verdict::kLocalized) query.answer.planes.keyframe = ref;
    if (verdict == Verdict::kAmbiguous)
      query.answer.planes.places.push_back({ref, probability, 20});
    if (verdict == Verdict::kNotInMap && place > 0) {
      query.answer.planes.runner_up = PlaceCandidate{ref, probability, 10};
    }
    return query;
  }
  static ScoredQuery Localized(const std::vector<int>& truth, int place, double probability) {
    return Query(truth, Verdict::kLocalized, place, probability);
  }
  Evaluation Measure(const std::vector<ScoredQuery>& queries) const {
    return Evaluate(*index_, queries);
  }

  const std::shared_ptr<const MapIndex> index_ = MadeIndex();
};

TEST_F(EvaluationTest, RightIsTrueOrCovisible) {
  EXPECT_TRUE(IsRightPlace(*index_, {PlaceIdOf(KeyframeId{1})}, PlaceIdOf(KeyframeId{1})));
  EXPECT_TRUE(IsRightPlace(*index_, {PlaceIdOf(KeyframeId{1})}, PlaceIdOf(KeyframeId{4})))
      << "both saw plane 2";
  EXPECT_TRUE(IsRightPlace(*index_, {PlaceIdOf(KeyframeId{5}), PlaceIdOf(KeyframeId{1})},
                           PlaceIdOf(KeyframeId{2})));
  EXPECT_FALSE(IsRightPlace(*index_, {PlaceIdOf(KeyframeId{1})}, PlaceIdOf(KeyframeId{5})));
  EXPECT_FALSE(IsRightPlace(*index_, {}, PlaceIdOf(KeyframeId{5})));
}

TEST_F(EvaluationTest, OutcomesAreCounted) {
  const Evaluation e =
      Measure({Localized({1}, 2, 0.9), Localized({1}, 6, 0.9), Localized({}, 6, 0.9),
               Query({1}, Verdict::kNotInMap, 0, 0), Query({1}, Verdict::kAmbiguous, 1, 0.5),
               Query({}, Verdict::kAmbiguous, 1, 0.5), Query({}, Verdict::kNotInMap, 0, 0),
               Query({2}, Verdict::kBadImage, 0, 0)});
  EXPECT_EQ(e.queries, 8);
  EXPECT_EQ(e.positives, 5);
  EXPECT_EQ(e.negatives, 3);
  EXPECT_EQ(e.right, 1);
  EXPECT_EQ(e.wrong, 1);
  EXPECT_EQ(e.false_accepts, 1);
  EXPECT_EQ(e.ambiguous_positives, 1);
  EXPECT_EQ(e.ambiguous_negatives, 1);
  EXPECT_EQ(e.bad_images, 1);
  EXPECT_DOUBLE_EQ(e.recall.value(), 0.2);
  EXPECT_DOUBLE_EQ(e.precision.value(), 1.0 / 3);
}

TEST_F(EvaluationTest, FullPrecisionCountsOnlyWhatIsSurerThanEveryFalseAnswer) {
  const Evaluation e =
      Measure({Localized({1}, 1, 0.99), Localized({1}, 1, 0.9), Localized({2}, 2, 0.8),
               Localized({}, 6, 0.9), Localized({1}, 5, 0.3)});
  EXPECT_DOUBLE_EQ(e.threshold, 0.9);
  EXPECT_DOUBLE_EQ(e.recall_at_full_precision.value(), 0.25) << "0.9 itself isn't above 0.9";
  EXPECT_DOUBLE_EQ(e.recall.value(), 0.75);
}

TEST_F(EvaluationTest, WithoutFalseAnswersFullPrecisionIsRecall) {
  const Evaluation e = Measure({Localized({1}, 1, 0.0), Query({1}, Verdict::kNotInMap, 0, 0)});
  EXPECT_DOUBLE_EQ(e.threshold, -1);
  EXPECT_DOUBLE_EQ(e.recall_at_full_precision.value(), 0.5);
  EXPECT_DOUBLE_EQ(e.precision.value(), 1);
}

TEST_F(EvaluationTest, ReliabilityComparesStatedWithObserved) {
  const Evaluation e =
      Measure({Localized({1}, 1, 0.92), Localized({1}, 5, 0.98), Localized({1}, 1, 1.0),
               Query({1}, Verdict::kNotInMap, 1, 0.25), Query({}, Verdict::kNotInMap, 1, 0.21),
               Query({}, Verdict::kNotInMap, 0, 0), Query({1}, Verdict::kBadImage, 0, 0)});
  ASSERT_EQ(e.reliability.size(), 10u);
  EXPECT_EQ(e.reliability[9].count, 3);
  EXPECT_NEAR(e.reliability[9].stated, 2.9 / 3, 1e-12);
  EXPECT_NEAR(e.reliability[9].observed, 2.0 / 3, 1e-12);
  EXPECT_EQ(e.reliability[2].count, 2);
  EXPECT_NEAR(e.reliability[2].observed, 0.5, 1e-12);
  EXPECT_EQ(e.reliability[0].count, 1) << "the unreadable image states nothing";
  EXPECT_EQ(e.reliability[0].observed, 0);
  EXPECT_EQ(e.reliability_localized[9].count, 3);
  EXPECT_EQ(e.reliability_localized[2].count, 0);
}

TEST_F(EvaluationTest, LatencyLeavesOutUnreadableImages) {
  std::vector<ScoredQuery> queries(101, Localized({1}, 1, 1));
  for (int i = 0; i < 100; ++i) queries[i].answer.timing.total_ms = 100 - i;
  queries[100] = Query({1}, Verdict::kBadImage, 0, 0);
  queries[100].answer.timing.total_ms = 1e6;
  const Evaluation e = Measure(queries);
  EXPECT_DOUBLE_EQ(e.latency.total_ms.p50, 50);
  EXPECT_DOUBLE_EQ(e.latency.total_ms.p90, 90);
  EXPECT_DOUBLE_EQ(e.latency.total_ms.p99, 99);
  EXPECT_DOUBLE_EQ(e.latency.decode_ms.p99, 0);
}

TEST_F(EvaluationTest, PositionsOfLocalizedPositivesAlone) {
  std::vector<ScoredQuery> queries = {Localized({1}, 1, 1), Localized({1}, 2, 1),
                                      Localized({1}, 3, 1), Localized({}, 3, 1)};
  EXPECT_FALSE(Measure(queries).position.has_value());
  queries[0].error = PoseError{3, {}};
  queries[1].error = PoseError{4, {}};
  queries[3].error = PoseError{100, {}};
  const auto position = Measure(queries).position;
  ASSERT_TRUE(position.has_value());
  EXPECT_EQ(position->count, 2);
  EXPECT_DOUBLE_EQ(position->mean_m, 3.5);
  EXPECT_DOUBLE_EQ(position->rmse_m, std::sqrt(12.5));
  EXPECT_DOUBLE_EQ(position->median_m, 3);
  EXPECT_DOUBLE_EQ(position->max_m, 4);
}

TEST_F(EvaluationTest, TolerancesAreSharesOfAllPositives) {
  std::vector<ScoredQuery> queries = {Localized({1}, 1, 1), Localized({1}, 2, 1),
                                      Localized({1}, 3, 1), Query({1}, Verdict::kNotInMap, 0, 0)};
  for (ScoredQuery& query : queries) query.has_true_angle = true;
  queries[0].error = PoseError{0.1, 0.01};
  queries[1].error = PoseError{0.4, 0.5};
  queries[2].error = PoseError{0.2, {}};
  const auto within = Measure(queries).within;
  ASSERT_EQ(within.size(), 4u);
  EXPECT_DOUBLE_EQ(within[1].position, 0.5);
  EXPECT_DOUBLE_EQ(within[1].pose.value(), 0.25);
  EXPECT_DOUBLE_EQ(within[2].position, 0.75);
  EXPECT_DOUBLE_EQ(within[3].pose.value(), 0.25);
}

TEST_F(EvaluationTest, AnglesCountWhereOrientationsAreKnown) {
  std::vector<ScoredQuery> queries = {Localized({1}, 1, 1), Localized({1}, 2, 1),
                                      Query({1}, Verdict::kNotInMap, 0, 0), Localized({}, 1, 1)};
  queries[0].error = PoseError{0.1, {}};
  queries[1].error = PoseError{0.1, 0.01};
  const auto share = [&] { return Measure(queries).within[1]; };
  EXPECT_DOUBLE_EQ(share().position, 2.0 / 3);
  EXPECT_FALSE(share().pose.has_value());
  queries[3].has_true_angle = true;  // not in the map
  EXPECT_FALSE(share().pose.has_value());
  queries[1].has_true_angle = true;
  EXPECT_DOUBLE_EQ(share().pose.value(), 1);
  queries[2].has_true_angle = true;  // missed
  EXPECT_DOUBLE_EQ(share().pose.value(), 0.5);
}

// Where a query is relative to a panorama, in the layer's frame, and in the world.
TEST(ComparePose, MovesTheTruePoseAsTheAnswerSays) {
  constexpr double kScale = 0.5;
  constexpr double kNodeYaw = 1.1;  // in the world
  Answer answer;
  answer.verdict = Verdict::kLocalized;
  answer.heading = Heading{0.5, 0.01, HeadingFrame::kLayer};
  answer.panorama.emplace();
  answer.panorama->node.id = {4};
  answer.panorama->node.pose = {1, 2, 0.3};
  // 2 ahead of the node, 1 to its left, turned by 0.2 to the left.
  answer.panorama->pose = {1 + 2 * std::cos(0.3) - 1 * std::sin(0.3),
                           2 + 2 * std::sin(0.3) + 1 * std::cos(0.3), 0.5};
  const Eigen::Vector3d at(7, -3, 1.5);
  const PlacePoses poses = {
      {PlaceIdOf(AppearanceNodeId{4}), {WorldFromCamera(at, kNodeYaw), true}}};
  const Eigen::Vector3d ahead(std::cos(kNodeYaw), std::sin(kNodeYaw), 0);
  const Eigen::Vector3d left(-std::sin(kNodeYaw), std::cos(kNodeYaw), 0);
  const TruePose truth{WorldFromCamera(at + kScale * (2 * ahead + left), kNodeYaw + 0.2), true};
  const auto right = ComparePose(answer, poses, kScale, truth);
  ASSERT_TRUE(right.has_value());
  EXPECT_NEAR(right->metres, 0, 1e-9);
  EXPECT_NEAR(right->rad.value(), 0, 1e-7);
  const TruePose off{WorldFromCamera(at, kNodeYaw - 0.1), true};
  const auto wrong = ComparePose(answer, poses, kScale, off);
  EXPECT_NEAR(wrong->metres, kScale * std::sqrt(5.0), 1e-9);
  EXPECT_NEAR(wrong->rad.value(), 0.3, 1e-7);
  EXPECT_FALSE(ComparePose(answer, {}, kScale, truth).has_value());
  answer.verdict = Verdict::kNotInMap;
  EXPECT_FALSE(ComparePose(answer, poses, kScale, truth).has_value());
}

TEST_F(EvaluationTest, NothingAtAll) {
  const Evaluation e = Measure({});
  EXPECT_EQ(e.queries, 0);
  EXPECT_FALSE(e.recall.has_value());
  EXPECT_FALSE(e.precision.has_value());
  EXPECT_FALSE(e.recall_at_full_precision.has_value());
}

}  // namespace
}  // namespace waystone
