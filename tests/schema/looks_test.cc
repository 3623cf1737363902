// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "schema/file/map_problems.h"
#include "schema/file/map_store.h"
#include "tests/schema/made_map.h"

namespace waystone {
namespace {

constexpr MapShape kShape{.sequences = 2, .keyframes = 12, .planes = 8};

// Counts of the first plane and the first keyframe that have something to count, by both sequences.
MapData MapWithLooks() {
  MapData map = MadeMap(5, kShape);
  const auto plane =
      std::ranges::find_if(map.planes, [](const Plane& one) { return one.features.size() > 1; });
  const auto keyframe = std::ranges::find_if(
      map.keyframes, [](const Keyframe& one) { return one.landmarks.size() > 1; });
  for (const Sequence& sequence : map.sequences) {
    std::vector<FeatureLooks> features(plane->features.size(), {4, 2});
    features[0] = {255, 255};
    features[1] = {7, 0};
    map.looks.planes.push_back({plane->id, sequence.id, std::move(features)});
    map.looks.landmarks.push_back(
        {keyframe->id, sequence.id,
         std::vector<FeatureLooks>(static_cast<size_t>(keyframe->landmarks.size()), {3, 0})});
  }
  return map;
}

// The first problem of the map after `change` of its looks.
template <class Change>
std::string ProblemAfter(const Change& change) {
  MapData map = MapWithLooks();
  change(map.looks);
  const std::vector<MapProblem> problems = FindMapProblems(map);
  return problems.empty() ? "" : problems[0].where + ": " + problems[0].message;
}

// What reading finds in a file that was changed by `sql`.
void ExpectDamage(const std::string& sql) {
  const TemporaryFolder folder;
  WriteMap(MapWithLooks(), folder / "m.db", {});
  RunSql(folder / "m.db", sql);
  EXPECT_FALSE(CheckMap(folder / "m.db").empty()) << sql;
  EXPECT_EQ(ErrorOf([&] { ReadMap(folder / "m.db"); }).code(), ErrorCode::kMapDamaged) << sql;
}

TEST(Looks, AreReadAsTheyWereWritten) {
  const TemporaryFolder folder;
  WriteMap(MapWithLooks(), folder / "m.db", {});
  EXPECT_TRUE(CheckMap(folder / "m.db").empty());
  EXPECT_EQ(ReadMap(folder / "m.db").looks, MapWithLooks().looks);
}

TEST(Looks, MapsWithoutThemHaveNoTable) {
  const TemporaryFolder folder;
  WriteMap(MadeMap(5, kShape), folder / "m.db", {});
  EXPECT_EQ(ReadFile(folder / "m.db").find("_looks"), std::string::npos);
}

TEST(Looks, AreOfWhatTheMapHasEachOnceInOrder) {
  const auto contains = [](const std::string& problem, const std::string& part) {
    return problem.find(part) != std::string::npos;
  };
  EXPECT_EQ(ProblemAfter([](Looks&) {}), "");
  EXPECT_TRUE(contains(ProblemAfter([](Looks& looks) { std::ranges::reverse(looks.planes); }),
                       "unique and sorted by (plane, sequence)"));
  EXPECT_TRUE(contains(
      ProblemAfter([](Looks& looks) { looks.landmarks.push_back(looks.landmarks.back()); }),
      "unique and sorted by (keyframe, sequence)"));
  EXPECT_TRUE(
      contains(ProblemAfter([](Looks& looks) { looks.planes.back().plane = PlaneId{1'000'000}; }),
               "there is no plane 1000000"));
  EXPECT_TRUE(contains(
      ProblemAfter([](Looks& looks) { looks.landmarks.back().keyframe = KeyframeId{1'000'000}; }),
      "there is no keyframe 1000000"));
  EXPECT_TRUE(contains(
      ProblemAfter([](Looks& looks) { looks.planes.back().sequence = SequenceId{1'000'000}; }),
      "there is no sequence 1000000"));
  EXPECT_TRUE(contains(ProblemAfter([](Looks& looks) { looks.planes.front().features.pop_back(); }),
                       "features; the plane"));
  EXPECT_TRUE(
      contains(ProblemAfter([](Looks& looks) { looks.landmarks.front().landmarks.push_back({}); }),
               "features; the keyframe"));
  EXPECT_TRUE(contains(ProblemAfter([](Looks& looks) {
                         looks.planes.front().features[0] = {2, 3};
                       }),
                       "found more often than looked for"));
}

TEST(Looks, ThatWereTamperedWithAreFound) {
  ExpectDamage("DELETE FROM plane_looks WHERE id = 2");
  ExpectDamage("DELETE FROM landmark_looks WHERE id = 1");
  ExpectDamage("UPDATE plane_looks SET feature_count = 2147483647");
  ExpectDamage("UPDATE plane_looks SET feature_count = -1");
  ExpectDamage("UPDATE landmark_looks SET landmark_count = 9223372036854775807");
  ExpectDamage("UPDATE landmark_looks SET looks = zeroblob(length(looks))");
  ExpectDamage("UPDATE plane_looks SET looks = zeroblob(3)");
  ExpectDamage("UPDATE plane_looks SET sequence = 0");
  ExpectDamage("UPDATE plane_looks SET plane = -7");
}

// Maps are checked before they are written.
TEST(Looks, ThatSayTheImpossibleAreNotWritten) {
  const TemporaryFolder folder;
  MapData map = MapWithLooks();
  map.looks.planes.front().features.front() = {0, 1};
  EXPECT_ANY_THROW(WriteMap(map, folder / "m.db", {}));
  EXPECT_FALSE(std::filesystem::exists(folder / "m.db"));
}

}  // namespace
}  // namespace waystone
