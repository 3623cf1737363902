// SPDX-License-Identifier: Apache-2.0
#include "schema/file_replacer.h"

#include <gtest/gtest.h>

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
