// SPDX-License-Identifier: Apache-2.0
// What SQLite may allocate while a map that nobody vouches for is open.
#include "schema/file/heap_bound.h"

#include <SQLiteCpp/Statement.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <new>
#include <utility>

#include "schema/file/map_database.h"
#include "schema/file/map_store.h"
#include "schema/tables/memory.h"
#include "tests/schema/made_map.h"

namespace waystone {
namespace {

int64_t HeapLimit() { return sqlite3_hard_heap_limit64(-1); }

TEST(HeapBound, IsTheSumOfAllThatExist) {
  ASSERT_EQ(HeapLimit(), 0);
  {
    HeapBound one(50'000'000);
    EXPECT_EQ(HeapLimit(), 50'000'000);
    {
      const HeapBound two(20'000'000);
      EXPECT_EQ(HeapLimit(), 70'000'000);
      EXPECT_EQ(sqlite3_soft_heap_limit64(-1), 70'000'000);
    }
    const HeapBound moved(std::move(one));
    EXPECT_EQ(HeapLimit(), 50'000'000);
  }
  EXPECT_EQ(HeapLimit(), 0);
  EXPECT_EQ(sqlite3_soft_heap_limit64(-1), 0);
}

// A sort of 3,000 values of 90 kB, as an expression of a crafted schema could ask for.
TEST(HeapBound, EndsWhatAStatementOnAMapAllocates) {
  const TemporaryFolder folder;
  WriteMap(MadeMap(2), folder / "m.db", {});
  const auto sort = [](SQLite::Database& database) {
    SQLite::Statement rows(database,
                           "WITH RECURSIVE r(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM r LIMIT "
                           "3000) SELECT randomblob(90000) AS b FROM r ORDER BY b");
    return rows.executeStep();
  };
  {
    OpenedMap map = OpenReadOnly(folder / "m.db");
    *map.steps_left = 1'000'000'000;  // what bounds its time
    sqlite3_memory_highwater(1);
    EXPECT_THROW(WithCheckedMemory([&] { return sort(map.database); }), std::bad_alloc);
    EXPECT_LT(sqlite3_memory_highwater(0), 70'000'000);
  }
  SQLite::Database unbounded(":memory:", SQLite::OPEN_READWRITE);
  unbounded.exec("PRAGMA temp_store = MEMORY");
  EXPECT_TRUE(sort(unbounded));
  EXPECT_GT(sqlite3_memory_highwater(0), 200'000'000) << "the statement does no harm";
}

// A tenth of the bound, as schema/file/map_database.cc says.
TEST(HeapBound, LeavesRoomForSoundMaps) {
  const TemporaryFolder folder;
  WriteMap(MadeMap(2), folder / "m.db", {});
  sqlite3_memory_highwater(1);
  EXPECT_TRUE(CheckMap(folder / "m.db").empty());
  EXPECT_LT(sqlite3_memory_highwater(0), 7'000'000);
}

}  // namespace
}  // namespace waystone
