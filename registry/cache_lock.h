// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace waystone {

// Keeps other processes from using the folder of a MapCache, while it exists: a lock (flock) of the
// file "lock" in it. Not thread-safe.
class CacheLock {
 public:
  // Creates the folder if it is missing. Throws MapError(kFileUnwritable), also for a folder that
  // another process has locked.
  explicit CacheLock(const std::filesystem::path& folder);
  ~CacheLock();
  CacheLock(const CacheLock&) = delete;
  CacheLock& operator=(const CacheLock&) = delete;

  // Whether the locked file is still the one in the folder. If somebody removed it, or the whole
  // folder, another process may lock a new one.
  bool Holds() const;

 private:
  std::filesystem::path path_;
  int file_ = -1;
};

}  // namespace waystone
