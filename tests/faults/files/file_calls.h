// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

// The program that links file_calls.cc takes the place of the C library's open, read, write,
// truncate, sync and rename, for itself and for every library it loads, SQLite and libstdc++
// among them. Calls on the files of one watched folder are recorded, and fail where a test says so;
// all others pass.
namespace waystone {

enum class FileCallKind { kOpen, kRead, kWrite, kTruncate, kSync, kRename };

// A call that succeeded.
struct FileCall {
  FileCallKind kind = FileCallKind::kOpen;
  std::filesystem::path path = {};  // of a sync the folder itself, too
  std::filesystem::path to = {};    // of a rename
  int64_t at = 0;                   // of a write; the size of a truncated file
  std::string bytes = {};           // of a write
};

// What goes wrong: the call of this number, from 0, and with `lasting` all after it.
struct FileFault {
  int64_t call = -1;  // none
  int error = 0;      // errno
  bool lasting = false;
  // A write that fails stores its first half; as a disk does that becomes full.
  bool half_written = false;
};

// Watches a folder as long as it lives. One at a time, for one thread.
class WatchedCalls {
 public:
  explicit WatchedCalls(const std::filesystem::path& folder, const FileFault& fault = {});
  WatchedCalls(const WatchedCalls&) = delete;
  WatchedCalls& operator=(const WatchedCalls&) = delete;
  ~WatchedCalls();

  int64_t count() const;  // of calls so far, failed ones included
  const std::vector<FileCall>& succeeded() const;
};

}  // namespace waystone
