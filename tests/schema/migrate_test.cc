// SPDX-License-Identifier: Apache-2.0
#include "schema/file/migrate.h"

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Statement.h>
#include <gtest/gtest.h>

#include <set>

#include "schema/file/map_database.h"
#include "schema/file/map_store.h"
#include "tests/schema/made_map.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;

// The real steps and two made up ones.
std::vector<Migration> LongerSteps() {
  std::vector<Migration> steps(Migrations().begin(), Migrations().end());
  steps.push_back({"next", "ALTER TABLE keyframes ADD COLUMN exposure_s REAL;"});
  steps.push_back({"next_but_one",
                   "CREATE TABLE turns (id INTEGER PRIMARY KEY, angle_rad REAL) STRICT;"
                   "INSERT INTO turns SELECT id, 0.5 FROM keyframes;"
                   "UPDATE keyframes SET exposure_s = id * 0.25;"});
  return steps;
}

// Maps of older versions have no landmarks, which their index would have to know.
const MapShape kWithoutLandmarks{.max_landmarks = 0};
const auto kNoCheck = [](const fs::path&) {};

MapData WithoutPoses(MapData map) {
  map.poses.reset();
  return map;
}

class MigrateTest : public testing::Test {
 protected:
  MigrateTest() { WriteMap(MadeMap(31, kWithoutLandmarks), path_, {}); }

  double Number(const std::string& sql) {
    SQLite::Database database(path_.string());
    return database.execAndGet(sql).getDouble();
  }

  // Takes away what versions after this one brought.
  void MakeVersion(int version) {
    std::set<std::string> kept;
    for (const SchemaObject& object : ExpectedObjects(Migrations().first(version))) {
      kept.insert(object.name);
    }
    for (const SchemaObject& object : ExpectedObjects(Migrations())) {
      if (kept.contains(object.name)) continue;
      RunSql(path_, "DROP " + object.type + " " + object.name);
      RunSql(path_, "DELETE FROM contents WHERE table_name = '" + object.name + "'");
    }
    RunSql(path_, "PRAGMA user_version = " + std::to_string(version) + "; VACUUM");
  }

  TemporaryFolder folder_;
  fs::path path_ = folder_ / "m.db";
};

TEST_F(MigrateTest, AsManyStepsAsTheVersionSays) {
  EXPECT_EQ(static_cast<int>(Migrations().size()), kSchemaVersion);
  EXPECT_EQ(std::string(Migrations()[0].name), "0001_initial.sql");
}

TEST_F(MigrateTest, AMapOfThisVersionIsNotTouched) {
  const std::string before = ReadFile(path_);
  EXPECT_EQ(MigrateMap(path_), kSchemaVersion);
  EXPECT_EQ(ReadFile(path_), before);
}

TEST_F(MigrateTest, StepsAreAppliedInOrder) {
  const std::vector<Migration> steps = LongerSteps();
  fs::path checked;
  EXPECT_EQ(MigrateFile(path_, steps, [&](const fs::path& copy) { checked = copy; }),
            kSchemaVersion);
  EXPECT_EQ(checked.parent_path(), path_.parent_path());
  EXPECT_EQ(folder_.Names(), Names{"m.db"});
  EXPECT_EQ(Number("PRAGMA user_version"), steps.size());
  EXPECT_EQ(Number("SELECT count(*) FROM turns"),
            std::ssize(MadeMap(31, kWithoutLandmarks).keyframes));
  EXPECT_GT(Number("SELECT min(exposure_s) FROM keyframes"), 0);
  OpenedMap opened = OpenReadOnly(path_);
  SQLite::Database& database = opened.database;
  EXPECT_TRUE(CheckFile(opened, ExpectedObjects(steps)).problems.empty());
  EXPECT_TRUE(FindAlteredContents(database, ExpectedObjects(steps)).empty());
  // This program's own version is older now, and says so.
  EXPECT_EQ(ErrorOf([&] { MigrateMap(path_); }).code(), ErrorCode::kMapVersion);
}

TEST_F(MigrateTest, OnlyTheMissingStepsAreApplied) {
  const std::vector<Migration> steps = LongerSteps();
  MigrateFile(path_, std::span(steps).first(kSchemaVersion + 1), kNoCheck);
  EXPECT_EQ(MigrateFile(path_, steps, kNoCheck), kSchemaVersion + 1);
  EXPECT_EQ(MigrateFile(path_, steps, kNoCheck), kSchemaVersion + 2);
}

// A map of an older version is one without the tables and views that later ones brought.
TEST_F(MigrateTest, AMapOfVersionOneKeepsEverythingButHasNoIndex) {
  MakeVersion(1);
  EXPECT_EQ(ErrorOf([&] { ReadMap(path_); }).code(), ErrorCode::kMapVersion);
  EXPECT_EQ(MigrateMap(path_), 1);
  EXPECT_TRUE(CheckMap(path_).empty());
  MapData expected = MadeMap(31, kWithoutLandmarks);
  expected.index.reset();
  expected.verdict.reset();
  expected.appearance.reset();
  expected.orientation.reset();
  expected.poses.reset();
  EXPECT_EQ(WithoutVersion(ReadMap(path_)), expected);
}

TEST_F(MigrateTest, AMapOfVersionTwoKeepsEverythingButHasNoFurtherLayers) {
  MakeVersion(2);
  EXPECT_EQ(Number("SELECT count(*) FROM sqlite_schema WHERE tbl_name LIKE 'appearance%'"), 0);
  EXPECT_EQ(ErrorOf([&] { ReadMap(path_); }).code(), ErrorCode::kMapVersion);
  EXPECT_EQ(MigrateMap(path_), 2);
  EXPECT_TRUE(CheckMap(path_).empty());
  MapData expected = MadeMap(31, kWithoutLandmarks);
  expected.appearance.reset();
  expected.orientation.reset();
  expected.poses.reset();
  EXPECT_EQ(WithoutVersion(ReadMap(path_)), expected);
}

TEST_F(MigrateTest, AMapOfVersionFourKeepsEverythingButHasNoLandmarks) {
  MakeVersion(4);
  EXPECT_EQ(Number("SELECT count(*) FROM sqlite_schema WHERE name LIKE '%landmark%'"), 0);
  EXPECT_EQ(ErrorOf([&] { ReadMap(path_); }).code(), ErrorCode::kMapVersion);
  EXPECT_EQ(MigrateMap(path_), 4);
  EXPECT_TRUE(CheckMap(path_).empty());
  EXPECT_EQ(WithoutVersion(ReadMap(path_)), WithoutPoses(MadeMap(31, kWithoutLandmarks)));
}

TEST_F(MigrateTest, AMapOfVersionFiveKeepsEverythingButHasNoPoses) {
  const MapData map = MadeMap(32);
  fs::remove(path_);
  WriteMap(map, path_, {});
  MakeVersion(5);
  EXPECT_EQ(Number("SELECT count(*) FROM sqlite_schema WHERE name LIKE '%pose%'"), 0);
  EXPECT_EQ(ErrorOf([&] { ReadMap(path_); }).code(), ErrorCode::kMapVersion);
  EXPECT_EQ(MigrateMap(path_), 5);
  EXPECT_TRUE(CheckMap(path_).empty());
  EXPECT_EQ(WithoutVersion(ReadMap(path_)), WithoutPoses(map));
}

TEST_F(MigrateTest, AMapOfVersionThreeKeepsEverythingButHasNoMirror) {
  MapData expected = MadeMap(31, kWithoutLandmarks);
  for (uint64_t seed = 32; !expected.appearance->mirror; ++seed) {
    ASSERT_LT(seed, 64u);
    fs::remove(path_);
    expected = MadeMap(seed, kWithoutLandmarks);
    WriteMap(expected, path_, {});
  }
  MakeVersion(3);
  EXPECT_EQ(MigrateMap(path_), 3);
  EXPECT_TRUE(CheckMap(path_).empty());
  expected.appearance->mirror.reset();
  expected.poses.reset();
  EXPECT_EQ(WithoutVersion(ReadMap(path_)), expected);
}

// Written anew, a migrated map has the bytes that the same data have without a migration.
TEST_F(MigrateTest, AMigratedMapIsLikeOneWrittenToday) {
  MakeVersion(2);
  MigrateMap(path_);
  const MapData migrated = ReadMap(path_);
  MapData today = MadeMap(31, kWithoutLandmarks);
  today.appearance.reset();
  today.orientation.reset();
  today.poses.reset();
  WriteMap(migrated, folder_ / "migrated.db", {});
  WriteMap(today, folder_ / "today.db", {});
  EXPECT_EQ(ReadFile(folder_ / "migrated.db"), ReadFile(folder_ / "today.db"));
}

TEST_F(MigrateTest, FromAnEmptyDatabase) {
  fs::remove(path_);
  RunSql(path_, "PRAGMA application_id = " + std::to_string(kApplicationId) +
                    "; CREATE TABLE t (x); DROP TABLE t");
  EXPECT_EQ(MigrateFile(path_, Migrations(), kNoCheck), 0);
  EXPECT_EQ(Number("SELECT count(*) FROM keyframes"), 0);
  EXPECT_EQ(Number("PRAGMA user_version"), kSchemaVersion);
}

TEST_F(MigrateTest, AStepThatFailsLeavesTheFile) {
  std::vector<Migration> steps = LongerSteps();
  steps.push_back({"broken", "INSERT INTO no_such_table VALUES (1);"});
  const std::string before = ReadFile(path_);
  EXPECT_THROW(MigrateFile(path_, steps, kNoCheck), MapError);
  EXPECT_EQ(ReadFile(path_), before);
  EXPECT_EQ(folder_.Names(), Names{"m.db"});
}

TEST_F(MigrateTest, ACheckThatFailsLeavesTheFile) {
  const std::string before = ReadFile(path_);
  const auto refuse = [](const fs::path&) { throw MapError(ErrorCode::kMapDamaged, "no"); };
  EXPECT_EQ(ErrorOf([&] { MigrateFile(path_, LongerSteps(), refuse); }).code(),
            ErrorCode::kMapDamaged);
  EXPECT_EQ(ReadFile(path_), before);
  EXPECT_EQ(folder_.Names(), Names{"m.db"});
}

TEST_F(MigrateTest, ADamagedMapIsNotMigrated) {
  RunSql(path_, "UPDATE keyframes SET source = 'elsewhere'");
  const std::string before = ReadFile(path_);
  EXPECT_EQ(ErrorOf([&] { MigrateFile(path_, LongerSteps(), kNoCheck); }).code(),
            ErrorCode::kMapDamaged);
  EXPECT_EQ(ReadFile(path_), before);
}

}  // namespace
}  // namespace waystone
