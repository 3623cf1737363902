// SPDX-License-Identifier: Apache-2.0
#include "schema/file/file_replacer.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>

#include "tests/schema/made_map.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;

TEST(FileReplacer, ReplacesOnCommitAlone) {
  const TemporaryFolder folder;
  WriteFile(folder / "a", "old");
  {
    const FileReplacer file(folder / "a", true);
    EXPECT_EQ(file.temporary().parent_path(), folder.path());
    EXPECT_TRUE(file.temporary().filename().string().starts_with(".a.tmp-"));
    WriteFile(file.temporary(), "half");
  }
  EXPECT_EQ(ReadFile(folder / "a"), "old");
  EXPECT_EQ(folder.Names(), Names{"a"});
  FileReplacer file(folder / "a", true);
  WriteFile(file.temporary(), "new");
  EXPECT_EQ(ReadFile(folder / "a"), "old");
  file.Commit();
  EXPECT_EQ(ReadFile(folder / "a"), "new");
  EXPECT_EQ(folder.Names(), Names{"a"});
}

TEST(FileReplacer, KeepsOwnerAndPermissions) {
  if (geteuid() != 0) GTEST_SKIP() << "only root may give files away";
  const TemporaryFolder folder;
  WriteFile(folder / "a", "old");
  ASSERT_EQ(chown((folder / "a").c_str(), 1234, 4321), 0);
  ASSERT_EQ(chmod((folder / "a").c_str(), 0640), 0);
  FileReplacer file(folder / "a", true);
  WriteFile(file.temporary(), "new");
  file.Commit();
  struct stat status {};
  ASSERT_EQ(stat((folder / "a").c_str(), &status), 0);
  EXPECT_EQ(status.st_uid, 1234u);
  EXPECT_EQ(status.st_gid, 4321u);
  EXPECT_EQ(status.st_mode & 07777, 0640u);
}

TEST(FileReplacer, TwoAtOnceDontMeet) {
  const TemporaryFolder folder;
  FileReplacer first(folder / "a", true);
  FileReplacer second(folder / "a", true);
  EXPECT_NE(first.temporary(), second.temporary());
  WriteFile(first.temporary(), "first");
  WriteFile(second.temporary(), "second");
  second.Commit();
  first.Commit();
  EXPECT_EQ(ReadFile(folder / "a"), "first");
  EXPECT_EQ(folder.Names(), Names{"a"});
}

TEST(FileReplacer, AFileIsNoFolder) {
  const TemporaryFolder folder;
  WriteFile(folder / "s.db", "");
  for (const char* below : {"x.db", "deeper/x.db"}) {
    const fs::path target = folder / "s.db" / below;
    EXPECT_EQ(ErrorOf([&] { const FileReplacer file(target, true); }).what(),
              target.string() + ": " + (folder / "s.db").string() +
                  " is not a folder; choose another path");
  }
}

// A file that appears between the question and the rename isn't lost.
TEST(FileReplacer, WithoutOverwriteALateFileStays) {
  const TemporaryFolder folder;
  {
    FileReplacer file(folder / "a", false);
    WriteFile(folder / "a", "somebody else's");
    EXPECT_EQ(ErrorOf([&] { file.Commit(); }).code(), ErrorCode::kFileExists);
  }
  EXPECT_EQ(ReadFile(folder / "a"), "somebody else's");
  EXPECT_EQ(folder.Names(), Names{"a"});
}

// The id of a process that has ended.
pid_t DeadProcess() {
  const pid_t child = fork();
  if (child == 0) _exit(0);
  waitpid(child, nullptr, 0);
  return child;
}

void MakeOld(const fs::path& path) {
  fs::last_write_time(path, fs::file_time_type::clock::now() - std::chrono::hours(1));
}

TEST(FileReplacer, WhatAKilledProcessLeftIsRemoved) {
  const TemporaryFolder folder;
  const std::string dead = std::to_string(DeadProcess());
  const std::string living = std::to_string(getpid());
  const Names kept = {".a.db.tmp-" + dead + "-1",  // too young: its process may be elsewhere
                      ".a.db.tmp-" + living + "-7",
                      ".a.db.tmp-" + dead,
                      ".a.db.tmp-" + dead + "-0.old",
                      ".a.db.tmp--3-0",
                      ".a.db.tmp-x-0",
                      ".aa.db.tmp-" + dead + "-0",
                      "a.db.tmp-" + dead + "-0"};
  const Names gone = {".a.db.tmp-" + dead + "-0", ".a.db.tmp-" + dead + "-12"};
  for (const Names& names : {kept, gone}) {
    for (const std::string& name : names) {
      WriteFile(folder / name, "half");
      if (name != kept[0]) MakeOld(folder / name);
    }
  }
  fs::create_directory(folder / (".a.db.tmp-" + dead + "-2"));
  MakeOld(folder / (".a.db.tmp-" + dead + "-2"));
  {
    FileReplacer file(folder / "a.db", false);
    WriteFile(file.temporary(), "new");
    file.Commit();
  }
  for (const std::string& name : kept) EXPECT_TRUE(fs::exists(folder / name)) << name;
  for (const std::string& name : gone) EXPECT_FALSE(fs::exists(folder / name)) << name;
  EXPECT_EQ(ReadFile(folder / "a.db"), "new");
  EXPECT_EQ(folder.Names().size(), kept.size() + 2) << "a folder isn't ours, the map is";
}

TEST(FileReplacer, TargetsThatCantBe) {
  const TemporaryFolder folder;
  const auto code = [&](const fs::path& path) {
    return ErrorOf([&] { FileReplacer(path, true); }).code();
  };
  WriteFile(folder / "file", "");
  EXPECT_EQ(code(folder / "no/such/folder/a.db"), ErrorCode::kFileUnwritable);
  EXPECT_EQ(code(folder / "file/a.db"), ErrorCode::kFileUnwritable);
  EXPECT_EQ(code(folder.path()), ErrorCode::kFileUnwritable);
  EXPECT_EQ(code(folder.path() / ""), ErrorCode::kFileUnwritable);
  EXPECT_EQ(code("/dev/null"), ErrorCode::kFileUnwritable);
  EXPECT_EQ(code("/proc/a.db"), ErrorCode::kFileUnwritable);
  EXPECT_EQ(code(""), ErrorCode::kFileUnwritable);
  EXPECT_EQ(folder.Names(), Names{"file"});
}

TEST(FileReplacer, ANameWithoutAFolderIsHere) {
  const TemporaryFolder folder;
  const fs::path before = fs::current_path();
  fs::current_path(folder.path());
  FileReplacer file("a.db", false);
  WriteFile(file.temporary(), "x");
  file.Commit();
  fs::current_path(before);
  EXPECT_EQ(folder.Names(), Names{"a.db"});
}

}  // namespace
}  // namespace waystone
