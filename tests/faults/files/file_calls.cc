// SPDX-License-Identifier: Apache-2.0
#include "tests/faults/files/file_calls.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/sendfile.h>
#include <sys/uio.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <map>
#include <optional>

namespace waystone {
namespace {

namespace fs = std::filesystem;

struct Watch {
  fs::path folder;
  FileFault fault;
  int64_t calls = 0;
  std::vector<FileCall> succeeded;
  std::map<int, fs::path> open;  // descriptors of files in the folder, or of the folder
};

std::optional<Watch> watch;

// The C library's function that ours hides.
template <class Function>
Function* Hidden(Function*, const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

bool IsWatched(const fs::path& path) {
  return watch && (path == watch->folder || path.parent_path() == watch->folder);
}

const fs::path* WatchedPath(int descriptor) {
  if (!watch) return nullptr;
  const auto it = watch->open.find(descriptor);
  return it == watch->open.end() ? nullptr : &it->second;
}

// Whether the next watched call fails, and errno, then.
bool Fails() {
  const FileFault& fault = watch->fault;
  const int64_t call = watch->calls++;
  if (fault.call < 0 || (fault.lasting ? call < fault.call : call != fault.call)) return false;
  errno = fault.error;
  return true;
}

void Record(FileCall call) { watch->succeeded.push_back(std::move(call)); }

int Open(const char* path, int flags, mode_t mode) {
  static auto* const hidden = Hidden<int(const char*, int, ...)>(nullptr, "open64");
  const bool watched = IsWatched(path);
  if (watched && Fails()) return -1;
  const int descriptor = hidden(path, flags, mode);
  if (watch) watch->open.erase(descriptor);
  if (!watched || descriptor < 0) return descriptor;
  watch->open[descriptor] = path;
  Record({.kind = FileCallKind::kOpen, .path = path});
  if ((flags & O_TRUNC) != 0) Record({.kind = FileCallKind::kTruncate, .path = path});
  return descriptor;
}

ssize_t Read(int descriptor, void* bytes, size_t size, std::optional<off_t> at) {
  static auto* const read_at = Hidden<ssize_t(int, void*, size_t, off_t)>(nullptr, "pread64");
  static auto* const read_on = Hidden<ssize_t(int, void*, size_t)>(nullptr, "read");
  const fs::path* path = WatchedPath(descriptor);
  if (path != nullptr && Fails()) return -1;
  if (path != nullptr) Record({.kind = FileCallKind::kRead, .path = *path});
  return at ? read_at(descriptor, bytes, size, *at) : read_on(descriptor, bytes, size);
}

ssize_t Write(int descriptor, const void* bytes, size_t size, std::optional<off_t> at) {
  static auto* const write_at =
      Hidden<ssize_t(int, const void*, size_t, off_t)>(nullptr, "pwrite64");
  static auto* const write_on = Hidden<ssize_t(int, const void*, size_t)>(nullptr, "write");
  const fs::path* path = WatchedPath(descriptor);
  if (path == nullptr) {
    return at ? write_at(descriptor, bytes, size, *at) : write_on(descriptor, bytes, size);
  }
  if (!at) {
    at = lseek(descriptor, 0, SEEK_CUR);
    lseek(descriptor, static_cast<off_t>(size), SEEK_CUR);
  }
  const bool fails = Fails();
  const int error = errno;
  if (fails && watch->fault.half_written) write_at(descriptor, bytes, size / 2, *at);
  if (fails) {
    errno = error;
    return -1;
  }
  Record({.kind = FileCallKind::kWrite,
          .path = *path,
          .at = *at,
          .bytes = std::string(static_cast<const char*>(bytes), size)});
  return write_at(descriptor, bytes, size, *at);
}

int Truncate(int descriptor, off_t size) {
  static auto* const hidden = Hidden<int(int, off_t)>(nullptr, "ftruncate64");
  const fs::path* path = WatchedPath(descriptor);
  if (path != nullptr && Fails()) return -1;
  if (path != nullptr) Record({.kind = FileCallKind::kTruncate, .path = *path, .at = size});
  return hidden(descriptor, size);
}

int Sync(int descriptor) {
  static auto* const hidden = Hidden<int(int)>(nullptr, "fsync");
  const fs::path* path = WatchedPath(descriptor);
  if (path == nullptr) return hidden(descriptor);
  // The disk needn't really be asked: only this program says what would be lost.
  if (Fails()) return -1;
  Record({.kind = FileCallKind::kSync, .path = *path});
  return 0;
}

int Rename(const char* from, const char* to, unsigned flags) {
  static auto* const hidden =
      Hidden<int(int, const char*, int, const char*, unsigned)>(nullptr, "renameat2");
  const bool watched = IsWatched(from);
  if (watched && Fails()) return -1;
  const int failed = hidden(AT_FDCWD, from, AT_FDCWD, to, flags);
  if (watched && failed == 0) Record({.kind = FileCallKind::kRename, .path = from, .to = to});
  return failed;
}

// The flag says whether a mode follows.
mode_t ModeOf(int flags, va_list rest) {
  return (flags & O_CREAT) != 0 ? static_cast<mode_t>(va_arg(rest, unsigned)) : 0;
}

}  // namespace

WatchedCalls::WatchedCalls(const fs::path& folder, const FileFault& fault) {
  EXPECT_FALSE(watch.has_value()) << "one folder at a time";
  watch.emplace(Watch{.folder = folder, .fault = fault, .succeeded = {}, .open = {}});
}

WatchedCalls::~WatchedCalls() { watch.reset(); }

int64_t WatchedCalls::count() const { return watch->calls; }

const std::vector<FileCall>& WatchedCalls::succeeded() const { return watch->succeeded; }

}  // namespace waystone

extern "C" {

int open(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = waystone::ModeOf(flags, rest);
  va_end(rest);
  return waystone::Open(path, flags, mode);
}

int open64(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = waystone::ModeOf(flags, rest);
  va_end(rest);
  return waystone::Open(path, flags, mode);
}

ssize_t read(int descriptor, void* bytes, size_t size) {
  return waystone::Read(descriptor, bytes, size, std::nullopt);
}

ssize_t pread(int descriptor, void* bytes, size_t size, off_t at) {
  return waystone::Read(descriptor, bytes, size, at);
}

ssize_t pread64(int descriptor, void* bytes, size_t size, off64_t at) {
  return waystone::Read(descriptor, bytes, size, at);
}

ssize_t write(int descriptor, const void* bytes, size_t size) {
  return waystone::Write(descriptor, bytes, size, std::nullopt);
}

ssize_t pwrite(int descriptor, const void* bytes, size_t size, off_t at) {
  return waystone::Write(descriptor, bytes, size, at);
}

ssize_t pwrite64(int descriptor, const void* bytes, size_t size, off64_t at) {
  return waystone::Write(descriptor, bytes, size, at);
}

ssize_t writev(int descriptor, const iovec* parts, int count) {
  std::string bytes;
  for (int i = 0; i < count; ++i) {
    bytes.append(static_cast<const char*>(parts[i].iov_base), parts[i].iov_len);
  }
  return waystone::Write(descriptor, bytes.data(), bytes.size(), std::nullopt);
}

int ftruncate(int descriptor, off_t size) noexcept { return waystone::Truncate(descriptor, size); }

int ftruncate64(int descriptor, off64_t size) noexcept {
  return waystone::Truncate(descriptor, size);
}

int fsync(int descriptor) { return waystone::Sync(descriptor); }

int fdatasync(int descriptor) { return waystone::Sync(descriptor); }

int rename(const char* from, const char* to) noexcept { return waystone::Rename(from, to, 0); }

int renameat2(int, const char* from, int, const char* to, unsigned flags) noexcept {
  return waystone::Rename(from, to, flags);
}

// A copy inside the kernel would pass unseen: what copies takes read and write instead.
ssize_t sendfile(int, int, off_t*, size_t) noexcept {
  errno = ENOSYS;
  return -1;
}

ssize_t sendfile64(int, int, off64_t*, size_t) noexcept {
  errno = ENOSYS;
  return -1;
}

}  // extern "C"
