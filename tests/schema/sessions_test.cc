// SPDX-License-Identifier: Apache-2.0
#include "schema/sessions.h"

#include <gtest/gtest.h>

#include <string>

namespace waystone {
namespace {

MapData OfSequences(int count) {
  MapData map;
  map.info.name = "lab";
  map.info.program = "waystone 0.1.0";
  map.info.version = "sha256:1";
  map.info.options_json = R"({"planes":{"seed":1},"share":0.5})";
  for (int64_t id = 1; id <= count; ++id) map.sequences.emplace_back().id = {id};
  return map;
}

TEST(Sessions, AMapWithoutAHistoryIsOne) {
  const MapData map = OfSequences(2);
  EXPECT_FALSE(HasHistory(map));
  const std::vector<MapSession> expected{
      {"lab", "waystone 0.1.0", "sha256:1", {SequenceId{1}, SequenceId{2}}}};
  EXPECT_EQ(SessionsOf(map), expected);
  EXPECT_EQ(WithoutSessions(map.info.options_json), map.info.options_json);
}

TEST(Sessions, AreReadAsTheyAreRecorded) {
  MapData map = OfSequences(3);
  const std::string options = map.info.options_json;
  const std::vector<MapSession> sessions{
      {"day", "waystone 0.1.0", "sha256:2", {SequenceId{1}, SequenceId{3}}},
      {"ni\"ght\xff", "waystone 0.2.0", "", {SequenceId{2}}}};
  map.info.options_json = WithSessions(options, sessions);
  ASSERT_TRUE(HasHistory(map));
  EXPECT_EQ(SessionsOf(map)[0], sessions[0]);
  EXPECT_EQ(SessionsOf(map)[1].sequences, sessions[1].sequences);
  EXPECT_EQ(WithoutSessions(map.info.options_json), options);
  // In place of one that is there.
  map.info.options_json = WithSessions(map.info.options_json, {SessionsOf(OfSequences(3))[0]});
  EXPECT_EQ(SessionsOf(map).size(), 1u);
}

TEST(Sessions, HoldWhatIsOfTheirSequences) {
  MapData map = OfSequences(3);
  const MapSession evening{"evening", "", "", {SequenceId{2}, SequenceId{3}}};
  EXPECT_EQ(ContentsOf(map, evening), SessionContents{});
  for (const int64_t sequence : {1, 2, 3}) {
    Keyframe& keyframe = map.keyframes.emplace_back();
    keyframe.sequence = {sequence};
    keyframe.time_s = 10.0 * static_cast<double>(sequence);
  }
  map.appearance.emplace();
  for (const int64_t sequence : {1, 3, 3, 3}) {
    map.appearance->nodes.emplace_back().sequence = {sequence};
  }
  map.orientation.emplace();
  OrientationFrame& frame = map.orientation->frames.emplace_back();
  frame.sequence = {2};
  frame.time_s = 15;
  EXPECT_EQ(ContentsOf(map, evening), (SessionContents{2, 3, 1, 15.0, 30.0}));
}

TEST(Sessions, ThatNoRecordCanHaveAreNone) {
  MapData map = OfSequences(2);
  for (const std::string sessions :
       {"1", "[1]", "[{}]", R"([{"sequences":[1]}])", R"([{"sequences":[1,2,2]}])",
        R"([{"sequences":[2,1]}])", R"([{"sequences":[1]},{"sequences":[1,2]}])",
        R"([{"sequences":["1","2"]}])"}) {
    map.info.options_json = "{\"sessions\":" + sessions + "}";
    EXPECT_FALSE(HasHistory(map)) << sessions;
    EXPECT_EQ(SessionsOf(map).size(), 1u) << sessions;
  }
}

TEST(Sessions, DeepRecordsTakeNoStack) {
  const std::string deep = std::string(200'000, '[') + std::string(200'000, ']');
  MapData map = OfSequences(1);
  map.info.options_json = "{\"a\":" + deep + "}";
  map.info.options_json = WithSessions(map.info.options_json, SessionsOf(map));
  EXPECT_TRUE(HasHistory(map));
}

TEST(FindParts, FollowsPlanesAndEdges) {
  MapData map = OfSequences(4);
  for (int64_t id = 1; id <= 4; ++id) {
    Keyframe& keyframe = map.keyframes.emplace_back();
    keyframe.id = {10 * id};
    keyframe.sequence = {id};
    Plane& plane = map.planes.emplace_back();
    plane.id = {id};
    plane.reference = keyframe.id;
    plane.views.emplace_back().keyframe = keyframe.id;
  }
  using Parts = std::vector<std::vector<SequenceId>>;
  EXPECT_EQ(FindParts(map), (Parts{{{1}}, {{2}}, {{3}}, {{4}}}));
  map.planes[0].views.emplace_back().keyframe = {30};
  EXPECT_EQ(FindParts(map), (Parts{{{1}, {3}}, {{2}}, {{4}}}));
  map.edges.push_back({.a = {3}, .b = {4}, .from = {30}, .to = {40}});
  EXPECT_EQ(FindParts(map), (Parts{{{1}, {3}, {4}}, {{2}}}));
}

}  // namespace
}  // namespace waystone
