// SPDX-License-Identifier: Apache-2.0
#include "cli/files/chosen_ids.h"

#include <gtest/gtest.h>

#include <functional>

#include "core/base/error.h"
#include "schema/sessions.h"
#include "tests/server/service/made_map.h"

namespace waystone {
namespace {

constexpr auto kKeyframes = NamedKind::kKeyframes;

// Keyframes 1, 2, 5 and 9; sequence 2 has the last one.
MapData MapOfFour() {
  MapData map = MadeMap(1);
  for (const int64_t id : {5, 9}) {
    map.keyframes.push_back(map.keyframes.back());
    map.keyframes.back().id = {id};
  }
  map.sequences.push_back(map.sequences.front());
  map.sequences.back().id = {2};
  map.keyframes.back().sequence = {2};
  return map;
}

std::set<KeyframeId> Keyframes(const std::vector<int64_t>& ids) {
  std::set<KeyframeId> keyframes;
  for (const int64_t id : ids) keyframes.insert({id});
  return keyframes;
}

void ExpectRefusal(const std::function<void()>& act, ErrorCode code, const std::string& message) {
  try {
    act();
    FAIL() << message;
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), code);
    EXPECT_EQ(error.what(), message);
  }
}

TEST(RangesOfIds, ReadsIdsAndRanges) {
  EXPECT_EQ(RangesOfIds(MapOfFour(), kKeyframes, "9,1:5,2"),
            (std::vector<NamedRange>{{kKeyframes, 9, 9}, {kKeyframes, 1, 5}, {kKeyframes, 2, 2}}));
}

TEST(RangesOfIds, RefusesWhatIsNoListOfIdsOfTheMap) {
  const auto refused = [](const std::string& text, ErrorCode code, const std::string& message) {
    ExpectRefusal([&] { RangesOfIds(MapOfFour(), kKeyframes, text); }, code, message);
  };
  const std::string advice = " is not an id; give ids as 12, 120:180 or 3,5,9:12";
  for (const char* text : {"", "x", "1-5", "1:", ":5", "1:2:5", "99999999999999999999"}) {
    const bool begins = std::string(text) == "1:2:5";
    const std::string word = begins ? "2:5" : std::string(text) == "1:" || *text == ':' ? "" : text;
    refused(text, ErrorCode::kUsage, "--keyframes: '" + word + "'" + advice);
  }
  refused("5:2", ErrorCode::kUsage, "--keyframes: '5:2' ends before it begins");
  refused("1,3", ErrorCode::kNotFound, "the map has no keyframe 3; its ids are from 1 to 9");
}

TEST(RangesOfIds, OfAMapWithoutAny) {
  ExpectRefusal([] { RangesOfIds({}, kKeyframes, "1"); }, ErrorCode::kNotFound,
                "the map has no keyframe 1; it has no keyframes");
}

TEST(KeyframesOfIds, JoinsListsAndPassesOverIdsThatRangesSpan) {
  EXPECT_EQ(KeyframesOfIds(MapOfFour(), {"2:9", "1,2"}), Keyframes({1, 2, 5, 9}));
  EXPECT_EQ(KeyframesOfIds(MapOfFour(), {}), Keyframes({}));
}

// Keyframes 1, 2, 5 and 9 stand at x = 0, 1, 2, 3 in a frame with z up.
MapData PosedMapOfFour() {
  MapData map = MapOfFour();
  map.poses.emplace();
  Eigen::Isometry3d level = Eigen::Isometry3d::Identity();
  level.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;  // looks along x, its top is up
  for (const Keyframe& keyframe : map.keyframes) {
    level.translation().x() = static_cast<double>(map.poses->keyframes.size());
    map.poses->keyframes.push_back(MakeKeyframePose(keyframe.id, level));
  }
  return map;
}

TEST(KeyframesInPolygon, AreThoseThatStandInIt) {
  const NamedPolygon polygon = ReadPolygon("--region", "0.5,-1 2.5,-1 2.5,1 0.5,1");
  EXPECT_EQ(KeyframesInPolygon(PosedMapOfFour(), polygon), Keyframes({2, 5}));
  EXPECT_EQ(KeyframesInPolygon(PosedMapOfFour(), {{8, 8}, {9, 8}, {9, 9}}), Keyframes({}));
  ExpectRefusal([&] { KeyframesInPolygon(MapOfFour(), polygon); }, ErrorCode::kNoLayer,
                "the map has no positions for a region; build it with --poses, or give keyframes");
  ExpectRefusal([] { ReadPolygon("--region", "1,2 3;4"); }, ErrorCode::kUsage,
                "--region: '3;4' is not a corner; give corners as \"0,0 4.5,0 4.5,3\"");
}

TEST(KeyframesOfPlace, AreThoseThatItHolds) {
  MapData map = PosedMapOfFour();
  map.names = {{"Door", {{kKeyframes, 1, 2}}, {{{2.5, -1}, {3.5, -1}, {3.5, 1}, {2.5, 1}}}}};
  EXPECT_EQ(KeyframesOfPlace(map, "Door"), Keyframes({1, 2, 9}));
  ExpectRefusal([&] { KeyframesOfPlace(map, "Hall"); }, ErrorCode::kNotFound,
                "the map has no place named 'Hall'; it has 1, which waystone name lists");
}

TEST(KeyframesOfSession, FindsByNumberAndByName) {
  MapData map = MapOfFour();
  map.info.options_json =
      WithSessions("{}", {{"day", "waystone", "", {{1}}}, {"1", "waystone", "", {{2}}}});
  EXPECT_EQ(KeyframesOfSession(map, "day"), Keyframes({1, 2, 5}));
  EXPECT_EQ(KeyframesOfSession(map, "2"), Keyframes({9}));
  for (const char* text : {"0", "3", "night", ""}) {
    ExpectRefusal(
        [&] { KeyframesOfSession(map, text); }, ErrorCode::kNotFound,
        "the map has no session '" + std::string(text) + "'; it has 2, which waystone info lists");
  }
}

TEST(KeyframesOfSession, RefusesANumberThatIsTheNameOfAnother) {
  MapData map = MapOfFour();
  const auto name_sessions = [&](const std::string& first, const std::string& second) {
    map.info.options_json =
        WithSessions("{}", {{first, "waystone", "", {{1}}}, {second, "waystone", "", {{2}}}});
  };
  name_sessions("day", "1");
  ExpectRefusal([&] { KeyframesOfSession(map, "1"); }, ErrorCode::kUsage,
                "'1' is the number of session 'day' and the name of session 2; give the other name "
                "or number, or ids with --keyframes or --nodes");
  name_sessions("1", "1");
  ExpectRefusal([&] { KeyframesOfSession(map, "1"); }, ErrorCode::kUsage,
                "'1' is the number of session '1' and the name of session 2; give the other name "
                "or number, or ids with --keyframes or --nodes");
  name_sessions("1", "2");  // each named like its own number
  EXPECT_EQ(KeyframesOfSession(map, "1"), Keyframes({1, 2, 5}));
  EXPECT_EQ(KeyframesOfSession(map, "2"), Keyframes({9}));
}

TEST(KeyframesOfSession, RefusesANameOfSeveral) {
  MapData map = MapOfFour();
  map.info.options_json =
      WithSessions("{}", {{"day", "waystone", "", {{1}}}, {"day", "waystone", "", {{2}}}});
  ExpectRefusal([&] { KeyframesOfSession(map, "day"); }, ErrorCode::kUsage,
                "2 sessions are named 'day'; give the number of one");
  EXPECT_EQ(KeyframesOfSession(map, "2"), Keyframes({9}));
}

}  // namespace
}  // namespace waystone
