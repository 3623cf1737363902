// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "schema/file/map_problems.h"
#include "schema/file/map_store.h"
#include "tests/schema/made_map.h"

namespace waystone {
namespace {

MapData LinkedMap() {
  MapData map = MadeMap(5);
  const KeyframeId a = map.keyframes[0].id;
  const KeyframeId b = map.keyframes[1].id;
  const KeyframeId c = map.keyframes[2].id;
  map.links = {{a, b}, {a, c}, {b, c}};
  return map;
}

std::string ProblemWith(const std::vector<KeyframeLink>& links) {
  MapData map = MadeMap(5);
  map.links = links;
  const std::vector<MapProblem> problems = FindMapProblems(map);
  return problems.empty() ? "" : problems[0].where + ": " + problems[0].message;
}

TEST(KeyframeLinks, AreReadAsTheyWereWritten) {
  const TemporaryFolder folder;
  WriteMap(LinkedMap(), folder / "m.db", {});
  EXPECT_TRUE(CheckMap(folder / "m.db").empty());
  EXPECT_EQ(ReadMap(folder / "m.db").links, LinkedMap().links);
}

TEST(KeyframeLinks, MapsWithoutThemHaveNoTable) {
  const TemporaryFolder folder;
  WriteMap(MadeMap(5), folder / "m.db", {});
  EXPECT_EQ(ReadFile(folder / "m.db").find("keyframe_links"), std::string::npos);
}

TEST(KeyframeLinks, AreOfKeyframesOfTheMapEachOnceInOrder) {
  const std::vector<KeyframeLink> links = LinkedMap().links;
  EXPECT_EQ(ProblemWith(links), "");
  EXPECT_NE(ProblemWith({links[1], links[0]}).find("unique and sorted"), std::string::npos);
  EXPECT_NE(ProblemWith({links[0], links[0]}).find("unique and sorted"), std::string::npos);
  EXPECT_NE(ProblemWith({{links[0].b, links[0].a}}).find("a must be below b"), std::string::npos);
  EXPECT_NE(ProblemWith({{links[0].a, {1'000'000}}}).find("no keyframe 1000000"),
            std::string::npos);
}

TEST(KeyframeLinks, ThatWereTamperedWithAreFound) {
  const TemporaryFolder folder;
  WriteMap(LinkedMap(), folder / "m.db", {});
  RunSql(folder / "m.db", "DELETE FROM keyframe_links WHERE id = 2");
  EXPECT_FALSE(CheckMap(folder / "m.db").empty());
  EXPECT_EQ(ErrorOf([&] { ReadMap(folder / "m.db"); }).code(), ErrorCode::kMapDamaged);
}

}  // namespace
}  // namespace waystone
