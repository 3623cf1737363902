// SPDX-License-Identifier: Apache-2.0
// Every call of the system on which a write of a map depends fails once, and once with all after
// it.
#include "tests/faults/files/file_calls.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <iostream>
#include <optional>
#include <set>
#include <string>

#include "core/base/error.h"
#include "schema/file/map_store.h"
#include "tests/faults/files/map_writes.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;

// How a disk that breaks and one that is full answer.
std::vector<FileFault> FaultsOfCall(int64_t call) {
  return {{.call = call, .error = EIO},
          {.call = call, .error = EIO, .lasting = true},
          {.call = call, .error = ENOSPC, .half_written = true},
          {.call = call, .error = ENOSPC, .lasting = true, .half_written = true}};
}

// What the write with this fault threw, if it did.
std::optional<MapError> WriteWith(const FileFault& fault, const MapWrite& write,
                                  const TemporaryFolder& folder) {
  const WatchedCalls watched(folder.path(), fault);
  try {
    write.write(folder);
  } catch (const MapError& error) {
    return error;
  }
  return std::nullopt;
}

void ExpectOneLine(const MapError& error, const fs::path& path) {
  const std::string message = error.what();
  EXPECT_NE(error.code(), ErrorCode::kInternal) << message;
  EXPECT_NE(message.find(path.string()), std::string::npos) << message;
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

class FileFaults : public testing::TestWithParam<MapWrite> {};

TEST_P(FileFaults, EveryFailedCallLeavesTheOldMapOrTheNewOne) {
  const MapWrite& write = GetParam();
  const TemporaryFolder folder;
  write.prepare(folder);
  const std::string before = ReadFile(folder / "m.db");
  int64_t calls = 0;
  std::set<FileCallKind> kinds;
  {
    const WatchedCalls watched(folder.path());
    write.write(folder);
    calls = watched.count();
    for (const FileCall& call : watched.succeeded()) kinds.insert(call.kind);
  }
  const std::string after = ReadFile(folder / "m.db");
  ASSERT_NE(before, after);
  for (const FileCallKind kind : {FileCallKind::kOpen, FileCallKind::kRead, FileCallKind::kWrite,
                                  FileCallKind::kSync, FileCallKind::kRename}) {
    EXPECT_TRUE(kinds.contains(kind)) << "calls pass unseen";
  }
  int failed = 0;
  for (int64_t call = 0; call < calls; ++call) {
    for (const FileFault& fault : FaultsOfCall(call)) {
      SCOPED_TRACE("call " + std::to_string(call) + (fault.lasting ? " and on" : "") + ", errno " +
                   std::to_string(fault.error));
      WriteFile(folder / "m.db", before);
      const std::optional<MapError> error = WriteWith(fault, write, folder);
      if (error) {
        ExpectOneLine(*error, folder.path());
        ++failed;
      }
      ASSERT_TRUE(ReadFile(folder / "m.db") == (error ? before : after))
          << (error ? error->what() : "");
      ASSERT_EQ(folder.Names(), Names{"m.db"});
    }
  }
  std::cout << calls << " calls, " << failed << " failed writes\n";
  // All but the last sync, of the folder, without which the map is in place already.
  EXPECT_GE(failed, 4 * (calls - 4));
}

INSTANTIATE_TEST_SUITE_P(Writes, FileFaults, testing::Values(Overwrite(), Migrate()),
                         [](const auto& param) { return param.param.name; });

}  // namespace
}  // namespace waystone
