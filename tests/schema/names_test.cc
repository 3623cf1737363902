// SPDX-License-Identifier: Apache-2.0
#include <SQLiteCpp/SQLiteCpp.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "schema/file/map_database.h"
#include "schema/file/map_problems.h"
#include "schema/file/map_store.h"
#include "schema/layers/names/place_names.h"
#include "schema/layers/poses/horizontal.h"
#include "tests/schema/made_map.h"

namespace waystone {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

const NamedPolygon kSquare{{0, 0}, {2, 0}, {2, 2}, {0, 2}};

// A map whose first keyframes, a plane, panoramas and an area have names.
MapData NamedMap(uint64_t seed = 5) {
  MapData map = MadeMap(seed);
  const std::vector<int64_t> keyframes = IdsOf(map, NamedKind::kKeyframes);
  const std::vector<int64_t> planes = IdsOf(map, NamedKind::kPlanes);
  map.names = Canonical({{"Küche", {{NamedKind::kKeyframes, keyframes[0], keyframes[2]}}, {}},
                         {"Küche", {{NamedKind::kPlanes, planes[0], planes[0]}}, {}},
                         {"Area 51", {}, {kSquare}}});
  return map;
}

std::string FirstProblem(const std::filesystem::path& path) {
  const std::vector<MapProblem> problems = CheckMap(path);
  return problems.empty() ? "" : problems[0].where + ": " + problems[0].message;
}

TEST(Names, AreTextOnOneLine) {
  for (const char* good : {"K", "Kitchen, window side", "Küche", "厨房", "a\"b'c<d>&", "😀"}) {
    EXPECT_FALSE(FindNameProblem(good)) << good;
  }
  EXPECT_FALSE(FindNameProblem(std::string(200, 'x')));
  const std::vector<std::pair<std::string, std::string>> bad{
      {"", "empty"},
      {std::string(201, 'x'), "201 bytes"},
      {" a", "blank"},
      {"a\n", "control character"},
      {"\x1b[31mred", "\\u001b"},
      {"a\xC2\x9B"
       "b",
       "control character"},
      {"a\xE2\x80\xAE"
       "b",
       "control character"},
      {"\xFF", "UTF-8"},
      {"a\xC3", "UTF-8"},
      {"\xC0\xAF", "UTF-8"},          // overlong
      {"\xED\xA0\x80", "UTF-8"},      // surrogate
      {"\xF4\x90\x80\x80", "UTF-8"},  // beyond Unicode
  };
  for (const auto& [name, cause] : bad) {
    const auto problem = FindNameProblem(name);
    ASSERT_TRUE(problem) << name;
    EXPECT_NE(problem->find(cause), std::string::npos) << *problem;
  }
}

TEST(Names, HaveAreas) {
  EXPECT_DOUBLE_EQ(AreaOf(kSquare), 4);
  EXPECT_TRUE(Holds(kSquare, {1, 1}));
  EXPECT_FALSE(Holds(kSquare, {3, 1}));
  EXPECT_FALSE(Holds(kSquare, {1, -1}));
  const NamedPolygon hook{{0, 0}, {3, 0}, {3, 3}, {2, 3}, {2, 1}, {0, 1}};
  EXPECT_TRUE(Holds(hook, {2.5, 2}));
  EXPECT_FALSE(Holds(hook, {1, 2}));
  EXPECT_FALSE(FindPolygonProblem(hook));
  EXPECT_TRUE(FindPolygonProblem({{0, 0}, {1, 1}}));
  EXPECT_TRUE(FindPolygonProblem({{0, 0}, {1, 1}, {2, 2}}));
  EXPECT_TRUE(FindPolygonProblem({{0, 0}, {1, kNaN}, {2, 2}}));
  EXPECT_TRUE(FindPolygonProblem({{0, 0}, {1, 2e9}, {2, 2}}));
}

TEST(Names, HaveOneForm) {
  const auto keyframes = [](int64_t first, int64_t last) {
    return NamedRange{NamedKind::kKeyframes, first, last};
  };
  const std::vector<NamedPlace> places =
      Canonical({{"b", {keyframes(9, 9), keyframes(1, 4)}, {}},
                 {"a", {{NamedKind::kNodes, 2, 2}, keyframes(7, 8)}, {kSquare, kSquare}},
                 {"b", {keyframes(5, 6), keyframes(2, 3)}, {}},
                 {"empty", {}, {}}});
  ASSERT_EQ(places.size(), 2u);
  EXPECT_EQ(places[0].name, "a");
  EXPECT_EQ(places[0].ranges,
            (std::vector<NamedRange>{keyframes(7, 8), {NamedKind::kNodes, 2, 2}}));
  EXPECT_EQ(places[0].polygons.size(), 1u);
  EXPECT_EQ(places[1].ranges, (std::vector<NamedRange>{keyframes(1, 6), keyframes(9, 9)}));
  EXPECT_EQ(Canonical(places), places);
}

TEST(Names, AreWrittenAndRead) {
  const TemporaryFolder folder;
  const MapData map = NamedMap();
  WriteMap(map, folder / "m.db", {});
  EXPECT_EQ(ReadMap(folder / "m.db").names, map.names);
  EXPECT_EQ(FirstProblem(folder / "m.db"), "");
  WriteMap(map, folder / "again.db", {});
  EXPECT_EQ(ReadFile(folder / "m.db"), ReadFile(folder / "again.db"));
}

// Programs that don't know the tables see the same file as before.
TEST(Names, LeaveNoTraceInMapsWithoutThem) {
  const TemporaryFolder folder;
  WriteMap(MadeMap(5), folder / "m.db", {});
  EXPECT_EQ(ReadFile(folder / "m.db").find("place_"), std::string::npos);
  EXPECT_TRUE(ReadMap(folder / "m.db").names.empty());
}

TEST(Names, AreChangedInTheFile) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder / "m.db";
  WriteMap(MadeMap(5), path, {});
  RunSql(path,
         "CREATE TABLE mine (id INTEGER PRIMARY KEY, x TEXT); INSERT INTO mine VALUES (1, 'y')");
  MapData map = ReadMap(path);
  const std::string version = map.info.version;
  map.names = NamedMap().names;
  RewriteOptionalTables(map, path);
  EXPECT_EQ(FirstProblem(path), "");
  const MapData named = ReadMap(path);
  EXPECT_EQ(named.names, map.names);
  EXPECT_NE(named.info.version, version);
  EXPECT_NE(ReadFile(path).find("CREATE TABLE mine"), std::string::npos);
  EXPECT_EQ(folder.Names(), std::vector<std::string>{"m.db"});

  MapData without = named;
  without.names.clear();
  RewriteOptionalTables(without, path);
  EXPECT_EQ(FirstProblem(path), "");
  EXPECT_EQ(ReadFile(path).find("place_ranges"), std::string::npos);
  EXPECT_NE(ReadFile(path).find("CREATE TABLE mine"), std::string::npos);
  EXPECT_EQ(WithoutVersion(ReadMap(path)), MadeMap(5));
}

TEST(Names, AreNotWrittenIntoAnotherMap) {
  const TemporaryFolder folder;
  WriteMap(MadeMap(5), folder / "m.db", {});
  MapData map = ReadMap(folder / "m.db");
  map.names = NamedMap().names;
  WriteMap(MadeMap(6), folder / "m.db", {.overwrite = true});
  const std::string bytes = ReadFile(folder / "m.db");
  const MapError error = ErrorOf([&] { RewriteOptionalTables(map, folder / "m.db"); });
  EXPECT_EQ(error.code(), ErrorCode::kFileUnreadable);
  EXPECT_EQ(ReadFile(folder / "m.db"), bytes);
  EXPECT_EQ(folder.Names(), std::vector<std::string>{"m.db"});
}

TEST(Names, ThatWereTamperedWithAreFound) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"UPDATE place_ranges SET name = 'x'", "place_ranges: its values have CRC-32C"},
      {"DELETE FROM place_ranges", "place_ranges: 0 rows"},
      {"DROP TABLE place_polygons; VACUUM", "place_polygons: this table is missing"},
      {"UPDATE place_polygons SET corners = zeroblob(64)", "place_polygons 1: corners"},
      {"DROP TABLE place_ranges; CREATE TABLE place_ranges (id INTEGER PRIMARY KEY); VACUUM",
       "place_ranges: this table has the name of a table of Waystone's"}};
  for (const auto& [sql, problem] : cases) {
    const TemporaryFolder folder;
    WriteMap(NamedMap(), folder / "m.db", {});
    RunSql(folder / "m.db", sql);
    EXPECT_EQ(FirstProblem(folder / "m.db").substr(0, problem.size()), problem) << sql;
    EXPECT_EQ(ErrorOf([&] { ReadMap(folder / "m.db"); }).code(), ErrorCode::kMapDamaged) << sql;
  }
}

TEST(Names, MustFitTheMap) {
  const auto problem_with = [](const std::vector<NamedPlace>& names) {
    MapData map = MadeMap(5);
    map.names = names;
    const std::vector<MapProblem> problems = FindMapProblems(map);
    return problems.empty() ? std::string() : problems[0].message;
  };
  EXPECT_EQ(problem_with(NamedMap().names), "");
  const NamedRange nowhere{NamedKind::kKeyframes, 1'000'000, 1'000'000};
  EXPECT_NE(problem_with({{"a", {nowhere}, {}}}).find("1000000, which the map hasn't got"),
            std::string::npos);
  EXPECT_NE(problem_with({{"a\n", {}, {kSquare}}}).find("control character"), std::string::npos);
  EXPECT_NE(problem_with({{"a", {}, {{{0, 0}, {1, 1}}}}}).find("2 corners"), std::string::npos);
  EXPECT_NE(problem_with({{"b", {}, {kSquare}}, {"a", {}, {kSquare}}}).find("in order"),
            std::string::npos);
  EXPECT_NE(problem_with({{"a", {}, {NamedPolygon(kMaxNamedCorners + 1, {0, 0})}}}), "");
  MapData unplaced = MadeMap(5);
  unplaced.poses.reset();
  unplaced.appearance.reset();
  unplaced.names = {{"a", {}, {kSquare}}};
  EXPECT_NE(FindMapProblems(unplaced)[0].message.find("no positions"), std::string::npos);
}

TEST(Names, SurviveAMigration) {
  const TemporaryFolder folder;
  WriteMap(NamedMap(), folder / "m.db", {});
  std::vector<Migration> steps(Migrations().begin(), Migrations().end());
  steps.push_back({"next.sql", "CREATE TABLE later (id INTEGER PRIMARY KEY) STRICT;"});
  MigrateFile(folder / "m.db", steps, [](const auto&) {});
  OpenedMap opened = OpenReadOnly(folder / "m.db");
  ASSERT_TRUE(CheckFile(opened, ExpectedObjects(steps)).problems.empty());
  EXPECT_TRUE(FindAlteredContents(opened.database, ExpectedObjects(steps)).empty());
  EXPECT_EQ(opened.database.execAndGet("SELECT count(*) FROM place_ranges").getInt(), 2);
}

// Keyframes 1 to 6 become 11 to 16 without 13, and another one, 12, comes between.
TEST(Names, FollowRenumberedThings) {
  const auto map_of = [](const std::vector<int64_t>& ids) {
    MapData map;
    for (const int64_t id : ids) map.keyframes.emplace_back().id = {id};
    return map;
  };
  MapData from = map_of({1, 2, 3, 4, 5, 6});
  const MapData to = map_of({11, 12, 14, 15, 16, 17});
  from.names = {{"gone", {{NamedKind::kKeyframes, 3, 3}}, {}},
                {"kitchen", {{NamedKind::kKeyframes, 1, 4}}, {kSquare}}};
  const RenumberedPlaces renumbered =
      RenumberPlaces(from, to, [](NamedKind, int64_t id) -> std::optional<int64_t> {
        if (id == 3) return std::nullopt;
        return id == 1 ? 11 : id + 12;  // 2 is 14, 4 is 16
      });
  EXPECT_EQ(renumbered.lost, std::vector<std::string>{"gone"});
  ASSERT_EQ(renumbered.places.size(), 1u);
  EXPECT_EQ(renumbered.places[0].ranges,
            (std::vector<NamedRange>{{NamedKind::kKeyframes, 11, 11},
                                     {NamedKind::kKeyframes, 14, 14},
                                     {NamedKind::kKeyframes, 16, 16}}));
  EXPECT_EQ(renumbered.places[0].polygons, std::vector<NamedPolygon>{kSquare});
}

// Cameras that look along the frame's x, `up` being the direction of their tops.
PoseLayer LayerWithUp(const Eigen::Vector3d& up) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  const Eigen::Vector3d ahead = up.unitOrthogonal();
  pose.linear().col(0) = (-up).cross(ahead);
  pose.linear().col(1) = -up;
  pose.linear().col(2) = ahead;
  PoseLayer layer;
  layer.keyframes = {MakeKeyframePose({1}, pose)};
  return layer;
}

TEST(Horizontal, IsXAndYWhereZIsUp) {
  const Eigen::Vector3d tilted = Eigen::Vector3d(0.2, 0.1, 1).normalized();
  for (const Eigen::Vector3d& up : {Eigen::Vector3d::UnitZ().eval(), tilted}) {
    const Horizontal view = HorizontalOf(LayerWithUp(up));
    EXPECT_TRUE(view.Of({3, 4, 5}).isApprox(Eigen::Vector2d(3, 4), 1e-12));
  }
  EXPECT_TRUE(HorizontalOf({}).Of({3, 4, 5}).isApprox(Eigen::Vector2d(3, 4)));
}

TEST(Horizontal, FollowsTheTopsOfTheImages) {
  const Horizontal camera = HorizontalOf(LayerWithUp(-Eigen::Vector3d::UnitY()));
  EXPECT_TRUE(camera.Of({3, 4, 5}).isApprox(Eigen::Vector2d(3, 5), 1e-12));
  const Eigen::Vector3d up = Eigen::Vector3d(1, 2, 2) / 3;
  const Horizontal oblique = HorizontalOf(LayerWithUp(up));
  EXPECT_NEAR(oblique.Of(7 * up).norm(), 0, 1e-12);
  EXPECT_NEAR(oblique.right.cross(oblique.top).dot(up), 1, 1e-12);
}

}  // namespace
}  // namespace waystone
