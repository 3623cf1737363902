// SPDX-License-Identifier: Apache-2.0
// Maps that earlier programs wrote (golden/README.md), opened and migrated by this one.
#include <gtest/gtest.h>

#include "schema/file/map_store.h"
#include "tests/schema/made_map.h"
#include "tests/schema/map_summary.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

const fs::path kGolden = fs::path(WAYSTONE_SOURCE_DIR) / "tests/schema/golden";

class GoldenMapsTest : public testing::TestWithParam<std::string> {
 protected:
  GoldenMapsTest() {
    fs::copy_file(kGolden / (GetParam() + ".db"), map_);
    fs::permissions(map_, fs::perms::owner_read | fs::perms::owner_write);
  }
  // "v3_walk" has version 3.
  int version() const { return GetParam()[1] - '0'; }

  TemporaryFolder folder_;
  fs::path map_ = folder_ / "m.db";
};

TEST_P(GoldenMapsTest, HoldsAfterAMigrationWhatItWasWrittenWith) {
  if (version() < kSchemaVersion) {
    EXPECT_EQ(ErrorOf([&] { ReadMap(map_); }).code(), ErrorCode::kMapVersion);
  }
  EXPECT_EQ(MigrateMap(map_), version());
  EXPECT_TRUE(CheckMap(map_).empty());
  EXPECT_EQ(SummariseMap(ReadMap(map_)), ReadFile(kGolden / (GetParam() + ".txt")));
}

TEST_P(GoldenMapsTest, IsWrittenAndReadAgainWithoutALoss) {
  MigrateMap(map_);
  const MapData map = ReadMap(map_);
  WriteMap(map, folder_ / "again.db", {});
  EXPECT_EQ(WithoutVersion(ReadMap(folder_ / "again.db")), WithoutVersion(map));
}

// A bit of what an earlier program wrote must not come out of a migration changed.
TEST_P(GoldenMapsTest, ADamagedOneIsNotMigrated) {
  if (version() == kSchemaVersion) return;
  RunSql(map_, "UPDATE sequences SET frames = frames + 1");
  const std::string before = ReadFile(map_);
  EXPECT_EQ(ErrorOf([&] { MigrateMap(map_); }).code(), ErrorCode::kMapDamaged);
  EXPECT_EQ(ReadFile(map_), before);
}

INSTANTIATE_TEST_SUITE_P(Golden, GoldenMapsTest,
                         testing::Values("v1_made", "v2_made", "v3_walk", "v3_layers", "v4_walk",
                                         "v4_layers", "v5_walk", "v5_layers"),
                         [](const auto& golden) { return golden.param; });

}  // namespace
}  // namespace waystone
