// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "core/base/error.h"

namespace waystone {

// Replaces a file as a whole: creates an empty file beside it to write into, which Commit renames
// into place, and which the destructor removes without a Commit. Readers of the target see either
// the old file or the complete new one. A symbolic link is followed: the file that it names is
// replaced. Not thread-safe; any number of them may replace the same file at the same time, and the
// last one wins. Files that a killed process left beside the target are removed by the next
// FileReplacer of the same target, once they are ten minutes old.
class FileReplacer {
 public:
  // Throws MapError: kFileExists without `overwrite`; kFileUnwritable for a folder that is missing
  // or can't be written to, and for a target that isn't a plain file.
  FileReplacer(const std::filesystem::path& target, bool overwrite);
  FileReplacer(const FileReplacer&) = delete;
  FileReplacer& operator=(const FileReplacer&) = delete;
  ~FileReplacer();

  // Where to write, in the target's folder: ".lab.db.tmp-<process>-<number>".
  const std::filesystem::path& temporary() const { return temporary_; }

  // Flushes the written bytes to the disk and renames. Throws MapError as the constructor does.
  void Commit();

 private:
  std::filesystem::path target_;
  bool overwrite_;
  std::filesystem::path temporary_;
  bool committed_ = false;
};

// The error for a file that can't be written: its path, `cause`, the bytes it needs (0 when not
// known) and those that are free, and what to do. Returned for throwing. Thread-safe.
MapError UnwritableError(const std::filesystem::path& path, const std::string& cause,
                         int64_t needed_bytes);

}  // namespace waystone
