// SPDX-License-Identifier: Apache-2.0
// Memory runs out while maps are read, checked, written and migrated.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <memory>
#include <string>
#include <vector>

#include "localizer/index/map_index.h"
#include "schema/file/map_store.h"
#include "tests/faults/files/map_writes.h"
#include "tests/faults/memory/attack.h"
#include "tests/faults/memory/made_places.h"

namespace waystone {
namespace {

using Names = std::vector<std::string>;

class MapMemory : public testing::Test {
 protected:
  // So that every run asks for the same memory in the same order.
  const tbb::global_control one_thread_{tbb::global_control::max_allowed_parallelism, 1};
  const TemporaryFolder folder_;
};

TEST_F(MapMemory, AMapIsReadWholeOrNotAtAll) {
  WriteMap(PhotoMap(), folder_ / "m.db", {});
  const MapData expected = MapIndex::Build(ReadMap(folder_ / "m.db"))->map();
  std::shared_ptr<const MapIndex> index;
  const MemoryAttack attack = AttackMemory(
      "read a map", [&] { index = MapIndex::Build(ReadMap(folder_ / "m.db")); },
      [&](bool threw) {
        ASSERT_TRUE(threw || index->map() == expected);
        index.reset();
      });
  EXPECT_GT(attack.threw, attack.runs / 2);
}

TEST_F(MapMemory, ASoundMapIsNotCalledDamaged) {
  WriteMap(MadeMap(71, MapShape{}), folder_ / "m.db", {});
  std::vector<MapProblem> problems;
  const MemoryAttack attack = AttackMemory(
      "check a map", [&] { problems = CheckMap(folder_ / "m.db"); },
      [&](bool threw) {
        ASSERT_TRUE(threw || problems.empty()) << problems[0].where << problems[0].message;
      });
  EXPECT_GT(attack.threw, attack.runs / 2);
}

TEST_F(MapMemory, AWriteLeavesTheOldMapOrTheNewOne) {
  for (const MapWrite& write : {Overwrite(), Migrate()}) {
    const TemporaryFolder folder;
    write.prepare(folder);
    const std::string before = ReadFile(folder / "m.db");
    write.write(folder);
    const std::string after = ReadFile(folder / "m.db");
    WriteFile(folder / "m.db", before);
    AttackMemory(
        write.name, [&] { write.write(folder); },
        [&](bool threw) {
          ASSERT_TRUE(ReadFile(folder / "m.db") == (threw ? before : after));
          ASSERT_EQ(folder.Names(), Names{"m.db"});
          WriteFile(folder / "m.db", before);
        });
  }
}

}  // namespace
}  // namespace waystone
