// SPDX-License-Identifier: Apache-2.0
#include "registry/cache_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "core/base/error.h"
#include "schema/file/file_replacer.h"

namespace waystone {

CacheLock::CacheLock(const std::filesystem::path& folder) : path_(folder / "lock") {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw UnwritableError(folder, error.message(), 0);
  file_ = open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (file_ < 0) throw UnwritableError(path_, std::strerror(errno), 0);
  if (flock(file_, LOCK_EX | LOCK_NB) == 0) return;
  const int cause = errno;
  close(file_);
  if (cause != EWOULDBLOCK) throw UnwritableError(path_, std::strerror(cause), 0);
  throw MapError(ErrorCode::kFileUnwritable,
                 folder.string() +
                     " is the cache of another server that runs; give each server a folder of "
                     "its own (--cache)");
}

CacheLock::~CacheLock() { close(file_); }

bool CacheLock::Holds() const {
  struct stat ours = {};
  struct stat there = {};
  return fstat(file_, &ours) == 0 && stat(path_.c_str(), &there) == 0 &&
         ours.st_dev == there.st_dev && ours.st_ino == there.st_ino;
}

}  // namespace waystone
