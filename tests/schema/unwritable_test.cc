// SPDX-License-Identifier: Apache-2.0
// Full disks and folders that can't be written to, as real ones as this machine lets a test make.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>

#include "schema/file/map_store.h"
#include "tests/schema/made_map.h"
#include "tests/schema/mounted_folder.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;

MapData LargeMap() {
  MapShape shape;
  shape.keyframes = 30;
  shape.jpeg_bytes = 60'000;
  return MadeMap(41, shape);
}

void ExpectUnwritable(const MapError& error, const fs::path& path) {
  const std::string message = error.what();
  EXPECT_EQ(error.code(), ErrorCode::kFileUnwritable) << message;
  EXPECT_NE(message.find(path.string()), std::string::npos) << message;
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

TEST(Unwritable, AFullDiskLeavesWhatWasThere) {
  const TemporaryFolder folder;
  const MountedFolder disk(folder.path(), "size=300k");
  if (!disk.mounted()) GTEST_SKIP() << "mounting a file system isn't possible here";
  WriteMap(MadeMap(42), folder / "m.db", {});
  const std::string before = ReadFile(folder / "m.db");
  const MapError error =
      ErrorOf([&] { WriteMap(LargeMap(), folder / "m.db", {.overwrite = true}); });
  ExpectUnwritable(error, folder / "m.db");
  EXPECT_NE(std::string(error.what()).find("disk is full"), std::string::npos) << error.what();
  EXPECT_NE(std::string(error.what()).find("MB free"), std::string::npos) << error.what();
  EXPECT_NE(std::string(error.what()).find("MB required"), std::string::npos) << error.what();
  EXPECT_EQ(ReadFile(folder / "m.db"), before);
  EXPECT_EQ(folder.Names(), Names{"m.db"});
}

TEST(Unwritable, ADiskThatIsJustTooSmall) {
  const TemporaryFolder sizes;
  WriteMap(LargeMap(), sizes / "m.db", {});
  const auto needed = static_cast<int64_t>(fs::file_size(sizes / "m.db"));
  const TemporaryFolder folder;
  // From a disk on which the last page doesn't fit to one with room to spare.
  for (const int64_t spare : {-32'768, -4'096, 65'536}) {
    const MountedFolder disk(folder.path(), "size=" + std::to_string(needed + spare));
    if (!disk.mounted()) GTEST_SKIP() << "mounting a file system isn't possible here";
    if (spare > 0) {
      WriteMap(LargeMap(), folder / "m.db", {});
      EXPECT_EQ(ReadFile(folder / "m.db"), ReadFile(sizes / "m.db"));
    } else {
      ExpectUnwritable(ErrorOf([&] { WriteMap(LargeMap(), folder / "m.db", {}); }),
                       folder / "m.db");
      EXPECT_EQ(folder.Names(), Names{});
    }
  }
}

// Needs no mount: the system refuses to let a file of this process grow.
TEST(Unwritable, AFileThatMayNotGrow) {
  const TemporaryFolder folder;
  WriteMap(MadeMap(42), folder / "m.db", {});
  const std::string before = ReadFile(folder / "m.db");
  rlimit old_limit{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &old_limit), 0);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit{200'000, old_limit.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
  const MapError error =
      ErrorOf([&] { WriteMap(LargeMap(), folder / "m.db", {.overwrite = true}); });
  setrlimit(RLIMIT_FSIZE, &old_limit);
  std::signal(SIGXFSZ, old_handler);
  ExpectUnwritable(error, folder / "m.db");
  EXPECT_EQ(ReadFile(folder / "m.db"), before);
  EXPECT_EQ(folder.Names(), Names{"m.db"});
}

TEST(Unwritable, AReadOnlyFileSystemIsReadButNotWritten) {
  const TemporaryFolder folder;
  MountedFolder disk(folder.path(), "size=1m");
  if (!disk.mounted()) GTEST_SKIP() << "mounting a file system isn't possible here";
  WriteMap(MadeMap(43), folder / "m.db", {});
  if (!disk.MakeReadOnly()) GTEST_SKIP() << "remounting read-only isn't possible here";
  EXPECT_EQ(WithoutVersion(ReadMap(folder / "m.db")), MadeMap(43));
  EXPECT_TRUE(CheckMap(folder / "m.db").empty());
  EXPECT_FALSE(TableSizes(folder / "m.db").empty());
  EXPECT_EQ(MigrateMap(folder / "m.db"), kSchemaVersion);
  for (const std::string name : {"m.db", "new.db"}) {
    ExpectUnwritable(ErrorOf([&] { CheckWritable(folder / name, {.overwrite = true}); }),
                     folder / name);
    ExpectUnwritable(ErrorOf([&] { WriteMap({}, folder / name, {.overwrite = true}); }),
                     folder / name);
  }
  EXPECT_EQ(folder.Names(), Names{"m.db"});
}

TEST(Unwritable, AFolderWithoutPermission) {
  if (geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  const TemporaryFolder folder;
  WriteMap(MadeMap(44), folder / "m.db", {});
  fs::permissions(folder.path(), fs::perms::owner_read | fs::perms::owner_exec);
  ExpectUnwritable(ErrorOf([&] { CheckWritable(folder / "n.db", {}); }), folder / "n.db");
  EXPECT_EQ(WithoutVersion(ReadMap(folder / "m.db")), MadeMap(44));
  fs::permissions(folder / "m.db", fs::perms::none);
  EXPECT_EQ(ErrorOf([&] { ReadMap(folder / "m.db"); }).code(), ErrorCode::kFileUnreadable);
  fs::permissions(folder.path(), fs::perms::owner_all);
}

TEST(Unwritable, AFolderThatIsNotThere) {
  const TemporaryFolder folder;
  const fs::path path = folder / "missing/m.db";
  ExpectUnwritable(ErrorOf([&] { CheckWritable(path, {}); }), path);
  ExpectUnwritable(ErrorOf([&] { WriteMap({}, path, {}); }), path);
  EXPECT_EQ(folder.Names(), Names{});
}

}  // namespace
}  // namespace waystone
