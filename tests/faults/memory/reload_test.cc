// SPDX-License-Identifier: Apache-2.0
// Memory runs out while a server reads its maps, at the start and later.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/commands/served_files.h"
#include "schema/file/map_store.h"
#include "tests/faults/files/map_writes.h"
#include "tests/faults/memory/attack.h"
#include "tests/faults/memory/made_places.h"

namespace waystone {
namespace {

class ReloadMemory : public testing::Test {
 protected:
  // So that every run asks for the same memory in the same order.
  const tbb::global_control one_thread_{tbb::global_control::max_allowed_parallelism, 1};
  const TemporaryFolder folder_;
};

TEST_F(ReloadMemory, AReloadKeepsTheOldMapAndTriesAgain) {
  WriteMap(PanoramaMap(), folder_ / "m.db", {});
  ServedFiles files({folder_ / "m.db"});
  MapCatalog catalog(files.OpenAll().maps);
  const std::string version = catalog.Find("m")->version();
  std::optional<std::vector<ServedFiles::Change>> changes;
  int kept = 0;
  AttackMemory(
      "reload a map",
      [&] {
        changes.reset();
        changes = files.Refresh(catalog, true);
      },
      [&](bool threw) {
        ASSERT_EQ(catalog.Find("m")->version(), version);
        if (threw) return;
        ASSERT_EQ(changes->size(), 1U);
        const ServedFiles::Change change = changes->front();
        ASSERT_EQ(change.good, !change.retry) << change.message;
        if (change.good) return;
        ++kept;
        ASSERT_EQ(change.message,
                  "not reloaded, out of memory; still serving the previous version, trying again");
        changes = files.Refresh(catalog, false);
        ASSERT_EQ(changes->size(), 1U) << "the file isn't looked at again";
        ASSERT_TRUE(changes->front().good) << changes->front().message;
      });
  EXPECT_GT(kept, 50);
}

TEST_F(ReloadMemory, AStartServesWhatFitsAndTheRestLater) {
  WriteMap(PhotoMap(), folder_ / "a.db", {});
  WriteMap(PanoramaMap(), folder_ / "b.db", {});
  std::optional<ServedFiles> files;
  std::optional<ServedFiles::Opened> opened;
  int partly = 0;
  AttackMemory(
      "start with two maps",
      [&] {
        opened.reset();
        files.emplace(std::vector<std::filesystem::path>{folder_.path()});
        opened = files->OpenAll();
      },
      [&](bool threw) {
        if (threw) return;
        MapCatalog catalog(opened->maps);
        if (!opened->refused.empty()) {
          ++partly;
          ASSERT_EQ(opened->refused.front().message, "out of memory; not served, trying again");
          files->Refresh(catalog, false);
        }
        ASSERT_EQ(catalog.Now()->size(), 2U);
      });
  EXPECT_GT(partly, 50);
}

}  // namespace
}  // namespace waystone
