// SPDX-License-Identifier: Apache-2.0
// Files that can't be served, beside others that can.
#include "cli/commands/served_files.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>

#include "core/base/error.h"
#include "schema/file/map_store.h"
#include "tests/server/service/made_map.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

class ServedFilesTest : public testing::Test {
 protected:
  ServedFilesTest() {
    std::string name = (fs::temp_directory_path() / "waystone-served-XXXXXX").string();
    EXPECT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  ~ServedFilesTest() override { fs::remove_all(folder_); }

  void WriteGood(const std::string& name) {
    MapData map = MadeMap(3);
    map.edges.clear();  // their homologies are made up
    WriteMap(map, folder_ / name, {.overwrite = true});
  }
  void WriteDamaged(const std::string& name) { std::ofstream(folder_ / name) << "no map"; }
  void WriteLoop(const std::string& name) { fs::create_symlink(name, folder_ / name); }

  fs::path folder_;
};

TEST_F(ServedFilesTest, BadFilesOfAFolderDontKeepTheOthersFromBeingServed) {
  WriteGood("good.db");
  WriteDamaged("bad.db");
  WriteLoop("loop.db");
  fs::create_directory(folder_ / "folder.db");
  ServedFiles files({folder_});
  const ServedFiles::Opened opened = files.OpenAll();
  ASSERT_EQ(opened.maps.size(), 1U);
  EXPECT_TRUE(opened.maps.contains("good"));
  ASSERT_EQ(opened.refused.size(), 2U);
  EXPECT_EQ(opened.refused[0].name, "bad");
  EXPECT_NE(opened.refused[0].message.find("not a Waystone map"), std::string::npos);
  EXPECT_EQ(opened.refused[1].name, "loop");
  EXPECT_FALSE(opened.refused[1].good);
}

TEST_F(ServedFilesTest, BadFilesAreNamedOnReloadAndTheOthersExchanged) {
  WriteGood("good.db");
  ServedFiles files({folder_});
  MapCatalog catalog(files.OpenAll().maps);
  WriteLoop("a_loop.db");
  WriteDamaged("bad.db");
  WriteGood("later.db");
  std::vector<ServedFiles::Change> changes = files.Refresh(catalog, false);
  ASSERT_EQ(changes.size(), 3U);
  EXPECT_NE(changes[0].message.find("; not served"), std::string::npos) << changes[0].message;
  EXPECT_NE(changes[1].message.find("; not served"), std::string::npos) << changes[1].message;
  EXPECT_TRUE(changes[2].good);
  EXPECT_TRUE(catalog.Now()->contains("later"));
  EXPECT_TRUE(files.Refresh(catalog, false).empty()) << "said once";
  fs::remove(folder_ / "good.db");
  WriteDamaged("good.db");
  changes = files.Refresh(catalog, false);
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_NE(changes[0].message.find("still serving"), std::string::npos) << changes[0].message;
  EXPECT_TRUE(catalog.Now()->contains("good"));
}

TEST_F(ServedFilesTest, AFolderThatCantBeReadKeepsTheOthersServed) {
  fs::create_directory(folder_ / "a");
  fs::create_directory(folder_ / "b");
  WriteGood("a/one.db");
  WriteGood("b/two.db");
  ServedFiles files({folder_ / "a/", folder_ / "b/."});
  MapCatalog catalog(files.OpenAll().maps);
  WriteGood("b/three.db");
  fs::permissions(folder_, fs::perms::all);
  fs::permissions(folder_ / "b", fs::perms::all);
  fs::permissions(folder_ / "b/three.db", fs::perms::all);
  fs::permissions(folder_ / "a", fs::perms::none);
  constexpr uid_t kNobody = 65534;
  const bool root = geteuid() == 0;
  if (root) {
    ASSERT_EQ(seteuid(kNobody), 0);
  }
  const std::vector<ServedFiles::Change> changes = files.Refresh(catalog, false);
  const std::vector<ServedFiles::Change> again = files.Refresh(catalog, false);
  if (root) {
    ASSERT_EQ(seteuid(0), 0);
  }
  fs::permissions(folder_ / "a", fs::perms::owner_all);
  ASSERT_EQ(changes.size(), 2U);
  EXPECT_EQ(changes[0].name, "");
  EXPECT_NE(changes[0].message.find("a' can't be read: Permission denied; check"),
            std::string::npos)
      << changes[0].message;
  EXPECT_EQ(changes[1].name, "three");
  EXPECT_TRUE(changes[1].good) << changes[1].message;
  EXPECT_TRUE(again.empty()) << "said once";
  EXPECT_EQ(catalog.Now()->size(), 3U);
  EXPECT_TRUE(files.Refresh(catalog, false).empty());
}

// As while it isn't mounted.
TEST_F(ServedFilesTest, AFolderThatIsGoneKeepsItsMapsServed) {
  fs::create_directory(folder_ / "a");
  WriteGood("a/one.db");
  ServedFiles files({folder_ / "a"});
  MapCatalog catalog(files.OpenAll().maps);
  fs::rename(folder_ / "a", folder_ / "away");
  const std::vector<ServedFiles::Change> changes = files.Refresh(catalog, false);
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_NE(changes[0].message.find("a' can't be read: No such file"), std::string::npos)
      << changes[0].message;
  EXPECT_EQ(catalog.Now()->size(), 1U);
  fs::rename(folder_ / "away", folder_ / "a");
  EXPECT_TRUE(files.Refresh(catalog, false).empty());
  fs::remove(folder_ / "a" / "one.db");
  ASSERT_EQ(files.Refresh(catalog, false).size(), 1U);
  EXPECT_TRUE(catalog.Now()->empty());
}

TEST_F(ServedFilesTest, OfTwoFilesOfOneNameTheServedOneStays) {
  fs::create_directory(folder_ / "a");
  fs::create_directory(folder_ / "b");
  WriteGood("b/one.db");
  ServedFiles files({folder_ / "a", folder_ / "b"});
  MapCatalog catalog(files.OpenAll().maps);
  fs::copy(folder_ / "b/one.db", folder_ / "a/one.db");
  WriteGood("b/two.db");
  const std::vector<ServedFiles::Change> changes = files.Refresh(catalog, false);
  ASSERT_EQ(changes.size(), 2U);
  EXPECT_NE(changes[0].message.find("have the same name"), std::string::npos);
  EXPECT_EQ(changes[1].name, "two");
  EXPECT_TRUE(files.Refresh(catalog, false).empty()) << "said once";
  EXPECT_THROW(ServedFiles({folder_ / "a", folder_ / "b"}).OpenAll(), MapError);
}

TEST_F(ServedFilesTest, AFileThatWasNamedMustBeGood) {
  WriteGood("good.db");
  WriteDamaged("bad.db");
  WriteLoop("loop.db");
  for (const char* name : {"bad.db", "loop.db", "missing.db"}) {
    EXPECT_THROW(ServedFiles({folder_ / "good.db", folder_ / name}).OpenAll(), MapError) << name;
  }
  fs::remove(folder_ / "good.db");
  EXPECT_THROW(ServedFiles({folder_}).OpenAll(), MapError) << "none is left";
}

}  // namespace
}  // namespace waystone
