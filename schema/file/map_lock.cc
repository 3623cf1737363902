// SPDX-License-Identifier: Apache-2.0
#include "schema/file/map_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <thread>

#include "core/base/error.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kBetweenTries{20};

// The descriptor of a regular file, or -1.
int OpenForLock(const fs::path& path) {
  constexpr int kFlags = O_CLOEXEC | O_NONBLOCK;  // a pipe would wait for its other end
  // NFS locks only files that are open for writing.
  int descriptor = open(path.c_str(), O_RDWR | kFlags);
  if (descriptor < 0) descriptor = open(path.c_str(), O_RDONLY | kFlags);
  struct stat status {};
  if (descriptor >= 0 && (fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode))) {
    close(descriptor);
    return -1;
  }
  return descriptor;
}

// Whether the path still leads to this file: the previous holder of the lock may have replaced it.
bool IsStillAt(const fs::path& path, int descriptor) {
  struct stat file {
  }, named{};
  if (fstat(descriptor, &file) != 0 || stat(path.c_str(), &named) != 0) return false;
  return file.st_dev == named.st_dev && file.st_ino == named.st_ino;
}

}  // namespace

MapLock::MapLock(const fs::path& path, std::chrono::milliseconds wait) {
  const Clock::time_point end = Clock::now() + wait;
  while (true) {
    descriptor_ = OpenForLock(path);
    if (descriptor_ < 0) return;
    const bool locked = flock(descriptor_, LOCK_EX | LOCK_NB) == 0;
    const bool held = !locked && (errno == EWOULDBLOCK || errno == EINTR);
    if (!locked && !held) return;  // no locks here
    if (locked && IsStillAt(path, descriptor_)) return;
    close(descriptor_);
    descriptor_ = -1;
    if (locked) continue;
    if (Clock::now() >= end) {
      throw MapError(ErrorCode::kFileUnwritable,
                     path.string() + " is being changed by another process; try again later");
    }
    std::this_thread::sleep_for(kBetweenTries);
  }
}

MapLock::~MapLock() {
  if (descriptor_ >= 0) close(descriptor_);
}

}  // namespace waystone
