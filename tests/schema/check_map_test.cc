// SPDX-License-Identifier: Apache-2.0
// CheckMap, ReadMap and TableSizes on files that aren't sound maps of this version.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "schema/file/map_store.h"
#include "tests/schema/made_map.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

bool Mentions(const std::vector<MapProblem>& problems, const std::string& where,
              const std::string& text) {
  for (const MapProblem& problem : problems) {
    if (problem.where.starts_with(where) && problem.message.find(text) != std::string::npos) {
      return true;
    }
  }
  return false;
}

std::string Listing(const std::vector<MapProblem>& problems) {
  std::string text;
  for (const MapProblem& problem : problems) text += problem.where + ": " + problem.message + "\n";
  return text;
}

class CheckMapTest : public testing::Test {
 protected:
  CheckMapTest() { WriteMap(MadeMap(2), path_, {}); }

  // What every way in says of the file: the same error.
  void ExpectRefused(const fs::path& path, ErrorCode code, const std::string& text) {
    for (const auto& open :
         std::vector<std::function<void()>>{[&] { ReadMap(path); }, [&] { CheckMap(path); },
                                            [&] { TableSizes(path); }, [&] { MigrateMap(path); }}) {
      const MapError error = ErrorOf(open);
      EXPECT_EQ(error.code(), code) << error.what();
      const std::string message = error.what();
      EXPECT_NE(message.find(text), std::string::npos) << message;
      EXPECT_NE(message.find(path.filename().string()), std::string::npos) << message;
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    }
  }

  // A fault put in by SQL: reading refuses it, and the check names the place and the cause.
  void ExpectFound(const std::string& sql, const std::string& where, const std::string& text) {
    WriteMap(MadeMap(2), path_, {.overwrite = true});
    RunSql(path_, sql);
    EXPECT_EQ(ErrorOf([&] { ReadMap(path_); }).code(), ErrorCode::kMapDamaged) << sql;
    const std::vector<MapProblem> problems = CheckMap(path_);
    EXPECT_TRUE(Mentions(problems, where, text)) << sql << "\n" << Listing(problems);
  }

  TemporaryFolder folder_;
  fs::path path_ = folder_ / "m.db";
};

TEST_F(CheckMapTest, ASoundMapHasNoProblems) { EXPECT_EQ(Listing(CheckMap(path_)), ""); }

TEST_F(CheckMapTest, WhatIsNotAMap) {
  WriteFile(folder_ / "text.db", "Dear diary, this is not a map at all.");
  ExpectRefused(folder_ / "text.db", ErrorCode::kNotAMap, "SQLite");
  WriteFile(folder_ / "empty.db", "");
  ExpectRefused(folder_ / "empty.db", ErrorCode::kNotAMap, "empty");
  RunSql(folder_ / "other.db", "CREATE TABLE planes (id); PRAGMA application_id = 7;");
  ExpectRefused(folder_ / "other.db", ErrorCode::kNotAMap, "application_id 7");
}

TEST_F(CheckMapTest, WhatCantBeRead) {
  ExpectRefused(folder_ / "missing.db", ErrorCode::kFileUnreadable, "No such file");
  ExpectRefused(folder_.path(), ErrorCode::kFileUnreadable, "folder");
  ASSERT_EQ(mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  ExpectRefused(folder_ / "pipe", ErrorCode::kFileUnreadable, "regular file");
}

TEST_F(CheckMapTest, AnotherVersion) {
  RunSql(path_, "PRAGMA user_version = 99");
  ExpectRefused(path_, ErrorCode::kMapVersion, "version 99");
  ExpectRefused(path_, ErrorCode::kMapVersion, "version " + std::to_string(kSchemaVersion));
  ExpectRefused(path_, ErrorCode::kMapVersion, "newer Waystone");
  RunSql(path_, "PRAGMA user_version = 0");
  EXPECT_NE(std::string(ErrorOf([&] { ReadMap(path_); }).what()).find("waystone migrate"),
            std::string::npos);
  RunSql(path_, "PRAGMA user_version = -7");
  ExpectRefused(path_, ErrorCode::kMapVersion, "-7, which no Waystone wrote");
}

TEST_F(CheckMapTest, BlobsOfAWrongLength) {
  ExpectFound("UPDATE plane_features SET keypoints = zeroblob(5)", "plane_features ", "5 bytes");
  ExpectFound("UPDATE plane_features SET votes = zeroblob(0) WHERE length(votes) > 0",
              "plane_features ", "expected");
  ExpectFound("UPDATE plane_features SET descriptors = zeroblob(9999999)", "plane_features ",
              "9999999");
  ExpectFound("UPDATE planes SET feature_count = 2000000000", "plane_features ", "expected");
  ExpectFound("UPDATE planes SET vertex_count = 2147483647", "planes ", "expected");
  ExpectFound("UPDATE plane_views SET homography = zeroblob(71)", "plane_views ", "71 bytes");
  ExpectFound("UPDATE sequences SET camera_params = zeroblob(8) WHERE camera_params IS NOT NULL",
              "sequences ", "expected");
}

TEST_F(CheckMapTest, BlobsChanged) {
  ExpectFound("UPDATE keyframe_images SET jpeg = CAST('other' AS BLOB)", "keyframe_images ",
              "CRC-32C");
  ExpectFound("UPDATE plane_views SET homography = zeroblob(72)", "plane_views ", "CRC-32C");
  ExpectFound("UPDATE edges SET homology_crc32c = homology_crc32c + 1", "edges ", "CRC-32C");
}

TEST_F(CheckMapTest, ADamagedSearchIndex) {
  ExpectFound("UPDATE search_index SET centres = zeroblob(length(centres))", "search_index 1",
              "CRC-32C");
  ExpectFound("UPDATE search_index SET lists = zeroblob(length(lists))", "search_index 1",
              "CRC-32C");
  ExpectFound("UPDATE search_index SET lists = zeroblob(7)", "search_index 1", "expected");
  ExpectFound("UPDATE search_index SET list_count = 2000000000", "search_index 1", "expected");
  ExpectFound("UPDATE search_index SET feature_count = 1", "search_index 1", "expected");
  ExpectFound("DELETE FROM search_index", "search_index", "0 rows");
  ExpectFound("UPDATE search_index SET format = 2", "search_index", "values");
  ExpectFound("UPDATE search_index SET format = 2, lists = zeroblob(7)", "search_index 1",
              "CRC-32C");
}

TEST_F(CheckMapTest, DamagedLayers) {
  ExpectFound("UPDATE appearance_signatures SET phases = zeroblob(length(phases))",
              "appearance_signatures ", "CRC-32C");
  ExpectFound("UPDATE appearance_layer SET k1 = 2000", "appearance_signatures ", "expected");
  ExpectFound("UPDATE appearance_layer SET k1 = 20000", "appearance_layer 1", "k1 is 20000");
  ExpectFound("DELETE FROM appearance_layer", "appearance_nodes 2", "has no row");
  ExpectFound("DELETE FROM appearance_signatures WHERE node = 5", "appearance_signatures 5", "0x0");
  ExpectFound("UPDATE appearance_edges SET kind = 2", "appearance_edges 2/5", "kind is 2");
  ExpectFound("UPDATE appearance_edges SET heading_rad = 0.5", "appearance_edges", "values");
  ExpectFound("DELETE FROM appearance_verdict", "appearance_verdict_terms 1", "has no row 1");
  ExpectFound("DELETE FROM orientation_layer", "orientation_frames 1", "has no row");
  ExpectFound("UPDATE orientation_frames SET qy = NULL WHERE id = 2", "orientation_frames 2",
              "qy is NULL");
  ExpectFound("UPDATE orientation_frames SET covariance = zeroblob(72)", "orientation_frames 1",
              "CRC-32C");
  ExpectFound("UPDATE orientation_turns SET confirmed = 2", "orientation_turns 3",
              "confirmed is 2");
  ExpectFound("DELETE FROM orientation_nodes WHERE frame = 5", "orientation_images 5",
              "no orientation node 5");
  ExpectFound("UPDATE corridors SET axis = 7", "corridors 1", "axis is 7");
}

TEST_F(CheckMapTest, ValuesChanged) {
  ExpectFound("UPDATE keyframes SET time_s = 12345.5", "keyframes", "values");
  ExpectFound("UPDATE sequences SET name = 'renamed'", "sequences", "values");
  ExpectFound("UPDATE map SET options = '{}'", "map", "values");
  ExpectFound("UPDATE plane_views SET inliers = inliers + 1", "plane_views", "values");
  ExpectFound("UPDATE map SET feature_type = 3", "map 1", "feature_type is 3");
  ExpectFound("UPDATE map SET feature_type = 1", "plane_features ", "expected");
  ExpectFound("UPDATE keyframes SET width = -5", "keyframes ", "width is -5");
  ExpectFound("UPDATE keyframes SET frame = 99999999999", "keyframes ", "frame is 99999999999");
  ExpectFound("UPDATE keyframes SET time_s = 9e999", "keyframes ", "finite");
  ExpectFound("UPDATE sequences SET camera_model = 77 WHERE camera_model IS NOT NULL", "sequences ",
              "camera_model is 77");
  ExpectFound("UPDATE edges SET third_eigenvalue = 9", "edges ", "eigenvalues");
}

TEST_F(CheckMapTest, RowsGoneOrAdded) {
  ExpectFound("DELETE FROM map", "map", "no row");
  ExpectFound("DELETE FROM edges", "edges", "0 rows");
  ExpectFound("DELETE FROM plane_features", "planes ", "no row in plane_features");
  ExpectFound("DELETE FROM contents WHERE table_name = 'planes'", "planes",
              "has no row in contents");
  ExpectFound("DELETE FROM plane_views", "planes ", "no view of its reference");
  ExpectFound("INSERT INTO keyframes VALUES (999, 999, 0, 0, '', NULL, 1, 1)", "keyframes 999",
              "no such sequence: 999");
  ExpectFound("DELETE FROM keyframes", "keyframes", "0 rows");
  ExpectFound("DELETE FROM keyframes", "plane_views", "does not exist");
}

TEST_F(CheckMapTest, SchemaAltered) {
  ExpectFound("DROP TABLE edges", "edges", "missing");
  ExpectFound("ALTER TABLE keyframes RENAME COLUMN source TO origin", "keyframes", "modified");
  ExpectFound("DROP VIEW plane_list; CREATE VIEW plane_list AS SELECT 1", "plane_list", "modified");
  ExpectFound("DROP TABLE planes; CREATE VIEW planes AS SELECT randomblob(1000000000) AS id",
              "planes", "missing");
}

TEST_F(CheckMapTest, ManyFaultsAreAllListed) {
  RunSql(path_,
         "UPDATE map SET name = 'x'; UPDATE keyframes SET width = 0;"
         "UPDATE plane_views SET homography = zeroblob(72);"
         "INSERT INTO keyframe_images VALUES (998, 0, CAST('x' AS BLOB));");
  const std::vector<MapProblem> problems = CheckMap(path_);
  EXPECT_TRUE(Mentions(problems, "map", "values")) << Listing(problems);
  EXPECT_TRUE(Mentions(problems, "keyframes ", "width")) << Listing(problems);
  EXPECT_TRUE(Mentions(problems, "plane_views ", "CRC")) << Listing(problems);
  EXPECT_TRUE(Mentions(problems, "keyframe_images 998", "no keyframe")) << Listing(problems);
}

// What people add for themselves is none of our business.
TEST_F(CheckMapTest, ForeignTablesAreLeftAlone) {
  RunSql(path_,
         "CREATE TABLE my_notes (note TEXT); INSERT INTO my_notes VALUES ('kitchen');"
         "CREATE INDEX my_index ON plane_views (keyframe);");
  EXPECT_EQ(Listing(CheckMap(path_)), "");
  EXPECT_EQ(WithoutVersion(ReadMap(path_)), MadeMap(2));
}

}  // namespace
}  // namespace waystone
