// SPDX-License-Identifier: Apache-2.0
// Queries with a deadline, queries of several maps, and what an answer says about the way to it.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "localizer/localizer.h"
#include "tests/localizer/made_map.h"

namespace waystone {
namespace {

LocalizeOptions WithDeadline(std::chrono::milliseconds from_now) {
  LocalizeOptions options;
  options.deadline = std::chrono::steady_clock::now() + from_now;
  return options;
}

std::vector<uint8_t> FlatImage() {
  const std::string text = "P5\n64 48\n255\n" + std::string(64 * 48, '\x80');
  return {text.begin(), text.end()};
}

TEST(Deadline, ThatPassedLeavesAQueryUndecided) {
  const MapData map = MadeMap();
  const auto index = MapIndex::Build(map);
  const LocalizeOptions late = WithDeadline(std::chrono::milliseconds(-1));
  const Answer answer = LocalizeFeatures(*index, QueryOf(map, {1, 2}, PoseOf(2), 200, 1), late);
  EXPECT_EQ(answer.verdict, Verdict::kUndecided);
  EXPECT_EQ(answer.last_stage, Stage::kShortlist);
  EXPECT_EQ(answer.decided_by, DecidedBy::kDeadline);
  EXPECT_EQ(answer.map, "made");
  EXPECT_EQ(Localize(*index, FlatImage(), "q", late).last_stage, Stage::kQueue) << "not decoded";
  EXPECT_EQ(Localize(*index, {}, "q", late).verdict, Verdict::kBadImage);
}

TEST(Deadline, ThatIsFarChangesNothingButTheStage) {
  const MapData map = MadeMap();
  const auto index = MapIndex::Build(map);
  const Features query = QueryOf(map, {1, 2}, PoseOf(2), 200, 1);
  const Answer with =
      LocalizeFeatures(*index, query, WithDeadline(std::chrono::milliseconds(3'600'000)));
  const Answer without = LocalizeFeatures(*index, query, {});
  EXPECT_EQ(with.verdict, Verdict::kLocalized);
  EXPECT_EQ(with.last_stage, Stage::kDecide);
  EXPECT_EQ(without.last_stage, std::nullopt);
  EXPECT_EQ(with.probability, without.probability);
}

TEST(Deadline, ThatPassedLeavesAReasonWhyThereIsNoPose) {
  MapData map = MadeMap();
  map.poses.emplace().frame = "building";
  const auto index = MapIndex::Build(std::move(map));
  const cv::Mat image(48, 64, CV_8UC1, cv::Scalar(90));
  const Answer late = LocalizeImage(*index, image, WithDeadline(std::chrono::milliseconds(-1)));
  EXPECT_EQ(late.verdict, Verdict::kUndecided);
  EXPECT_FALSE(late.pose);
  EXPECT_EQ(late.pose_reason, "not localized");
}

TEST(Answer, TellsWhatWasConsidered) {
  const MapData map = MadeMap();
  const auto index = MapIndex::Build(map);
  const Answer answer = LocalizeFeatures(*index, QueryOf(map, {1, 2}, PoseOf(2), 200, 1), {});
  ASSERT_FALSE(answer.planes.candidates.empty());
  EXPECT_EQ(answer.planes.candidates[0].keyframe.id, answer.planes.keyframe->id);
  EXPECT_EQ(answer.planes.candidates[0].probability, answer.probability);
}

TEST(LocalizeAcross, AnswersAsEachMapDoes) {
  const auto index = MapIndex::Build(MadeMap());
  const std::vector<Answer> answers =
      LocalizeAcross({index.get(), index.get()}, FlatImage(), "q", {});
  const Answer alone = Localize(*index, FlatImage(), "q", {});
  ASSERT_EQ(answers.size(), 2u);
  for (const Answer& answer : answers) {
    EXPECT_EQ(answer.verdict, alone.verdict);
    EXPECT_EQ(answer.message, alone.message);
    EXPECT_EQ(answer.image, "q");
    EXPECT_GT(answer.timing.total_ms, 0);
  }
  EXPECT_EQ(LocalizeAcross({index.get()}, std::span<const uint8_t>(), "q", {})[0].verdict,
            Verdict::kBadImage);
}

}  // namespace
}  // namespace waystone
