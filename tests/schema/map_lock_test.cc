// SPDX-License-Identifier: Apache-2.0
#include "schema/file/map_lock.h"

#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "schema/file/file_replacer.h"
#include "tests/schema/made_map.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

TEST(MapLock, TheSecondIsToldToTryAgain) {
  const TemporaryFolder folder;
  WriteFile(folder / "a", "map");
  fs::create_symlink("a", folder / "link");
  std::optional<MapLock> first(std::in_place, folder / "a");
  for (const char* name : {"a", "link"}) {
    const MapError error = ErrorOf([&] { const MapLock second(folder / name, milliseconds(30)); });
    EXPECT_EQ(error.code(), ErrorCode::kFileUnwritable);
    EXPECT_NE(std::string(error.what()).find("by another process; try again"), std::string::npos);
  }
  first.reset();
  const MapLock second(folder / "a", milliseconds(0));
}

// What was locked while somebody replaced it isn't the map any more.
TEST(MapLock, WhoWaitedLocksWhatIsThereNow) {
  const TemporaryFolder folder;
  WriteFile(folder / "a", "old");
  std::optional<MapLock> first(std::in_place, folder / "a");
  const auto waiting = std::async(std::launch::async, [&] {
    auto lock = std::make_unique<MapLock>(folder / "a");
    EXPECT_EQ(ReadFile(folder / "a"), "new");
    return lock;
  });
  std::this_thread::sleep_for(milliseconds(60));
  FileReplacer file(folder / "a", true);
  WriteFile(file.temporary(), "new");
  file.Commit();
  first.reset();
  waiting.wait();
  EXPECT_THROW(MapLock(folder / "a", milliseconds(30)), MapError);
}

TEST(MapLock, WhatIsNoFileIsNotLocked) {
  const TemporaryFolder folder;
  const MapLock missing(folder / "a", milliseconds(0)), same(folder / "a", milliseconds(0));
  const MapLock path(folder.path(), milliseconds(0)), again(folder.path(), milliseconds(0));
}

}  // namespace
}  // namespace waystone
