// SPDX-License-Identifier: Apache-2.0
#include "schema/file/file_replacer.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "core/base/error.h"
#include "schema/file/folder_entries.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

// The part of the target's name in the temporary one: a name has at most 255 bytes.
constexpr size_t kMaxNameBytes = 200;
// A temporary of a process that isn't running here is abandoned after this time without a change.
// Process ids don't suffice: a process in another container or on another machine may share the
// folder.
constexpr std::chrono::minutes kAbandonedAfter{10};

[[noreturn]] void ThrowExists(const fs::path& path) {
  throw MapError(
      ErrorCode::kFileExists,
      path.string() + " already exists; choose another name, or use --force to overwrite it");
}

[[noreturn]] void ThrowUnwritable(const fs::path& path, const std::string& cause,
                                  const std::string& remedy) {
  throw MapError(ErrorCode::kFileUnwritable, path.string() + ": " + cause + "; " + remedy);
}

fs::path FolderOf(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

// The target of a symbolic link: renaming onto the link would leave the file it points to
// unchanged.
fs::path Resolved(const fs::path& path) {
  std::error_code error;
  if (!fs::is_symlink(path, error)) return path;
  const fs::path resolved = fs::weakly_canonical(path, error);
  return error ? path : resolved;
}

// The part of a folder's path that is something else than a folder, if any.
std::optional<fs::path> FindFileInPath(const fs::path& folder) {
  for (fs::path part = folder; !part.empty(); part = part.parent_path()) {
    std::error_code error;
    const fs::file_status status = fs::status(part, error);
    if (fs::is_directory(status)) return std::nullopt;
    if (fs::exists(status)) return part;
    if (part == part.parent_path()) break;
  }
  return std::nullopt;
}

void CheckTarget(const fs::path& target, bool overwrite) {
  std::error_code error;
  const fs::path folder = FolderOf(target);
  if (!target.has_filename()) ThrowUnwritable(target, "is a folder", "append a file name");
  if (const auto file = FindFileInPath(folder)) {
    ThrowUnwritable(target, file->string() + " is not a folder", "choose another path");
  }
  if (!fs::is_directory(folder, error)) {
    ThrowUnwritable(target, "folder " + folder.string() + " does not exist",
                    "create it or choose another path");
  }
  const fs::file_status status = fs::status(target, error);
  if (!fs::exists(status)) return;
  if (fs::is_directory(status)) ThrowUnwritable(target, "is a folder", "append a file name");
  if (!fs::is_regular_file(status)) {
    ThrowUnwritable(target, "is not a regular file", "choose another path");
  }
  if (!overwrite) ThrowExists(target);
}

// The beginning of the names of a target's temporaries; "<process>-<number>" follows.
std::string StemOf(const fs::path& target) {
  std::string name = target.filename().string();
  if (name.size() > kMaxNameBytes) name.resize(kMaxNameBytes);
  return "." + name + ".tmp-";
}

// The process that a temporary belongs to, or nothing for a file that isn't one.
std::optional<pid_t> OwnerOf(std::string_view name, std::string_view stem) {
  if (!name.starts_with(stem)) return std::nullopt;
  name.remove_prefix(stem.size());
  const char* const end = name.data() + name.size();
  pid_t process = 0;
  const auto [dash, error] = std::from_chars(name.data(), end, process);
  if (error != std::errc() || process <= 0 || dash == end || *dash != '-') return std::nullopt;
  unsigned number = 0;
  const auto [rest, number_error] = std::from_chars(dash + 1, end, number);
  if (number_error != std::errc() || rest != end) return std::nullopt;
  return process;
}

bool IsAlive(pid_t process) { return kill(process, 0) == 0 || errno != ESRCH; }

// Removes what killed writers of the same target left behind. Whatever can't be examined or removed
// stays: that is no reason not to write.
void RemoveAbandoned(const fs::path& target) {
  const std::string stem = StemOf(target);
  std::vector<std::string> names;
  try {
    names = FolderEntries(FolderOf(target));
  } catch (const fs::filesystem_error&) {
    return;
  }
  for (const std::string& name : names) {
    const auto owner = OwnerOf(name, stem);
    if (!owner || IsAlive(*owner)) continue;
    const fs::path path = FolderOf(target) / name;
    std::error_code ignored;
    if (!fs::is_regular_file(fs::symlink_status(path, ignored))) continue;
    const fs::file_time_type changed = fs::last_write_time(path, ignored);
    if (ignored || fs::file_time_type::clock::now() - changed < kAbandonedAfter) continue;
    fs::remove(path, ignored);
  }
}

fs::path CreateTemporary(const fs::path& target) {
  const std::string stem = StemOf(target) + std::to_string(getpid()) + "-";
  for (int number = 0;; ++number) {
    fs::path path = FolderOf(target) / (stem + std::to_string(number));
    const int file = open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file >= 0) {
      close(file);
      return path;
    }
    if (errno != EEXIST) throw UnwritableError(target, std::strerror(errno), 0);
  }
}

// A replaced file keeps its owner and group, as far as this process may set them, and its
// permissions.
void CopyPermissions(const fs::path& from, const fs::path& to) {
  struct stat status {};
  if (stat(from.c_str(), &status) != 0) return;
  const bool owned = chown(to.c_str(), status.st_uid, status.st_gid) == 0;
  if (!owned && chown(to.c_str(), static_cast<uid_t>(-1), status.st_gid) != 0) {
    errno = 0;  // another group then
  }
  chmod(to.c_str(), status.st_mode & 07777);
}

bool Flush(const fs::path& path, int flags) {
  const int file = open(path.c_str(), flags | O_CLOEXEC);
  if (file < 0) return false;
  const bool flushed = fsync(file) == 0;
  const int cause = errno;
  close(file);
  errno = cause;
  return flushed;
}

// Renames only if there is no file at `to`.
bool RenameOntoNothing(const fs::path& from, const fs::path& to) {
  if (renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return true;
  if (errno != EINVAL && errno != ENOSYS) return false;
  // For file systems without it (some network ones): a race between the two calls remains.
  if (access(to.c_str(), F_OK) == 0) {
    errno = EEXIST;
    return false;
  }
  return std::rename(from.c_str(), to.c_str()) == 0;
}

std::string Megabytes(uintmax_t bytes) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.1f MB", static_cast<double>(bytes) / 1e6);
  return text;
}

}  // namespace

MapError UnwritableError(const fs::path& path, const std::string& cause, int64_t needed_bytes) {
  std::string message = path.string() + " can't be written: " + cause;
  if (needed_bytes > 0) message += ", " + Megabytes(needed_bytes) + " required";
  std::error_code error;
  const fs::space_info space = fs::space(FolderOf(path), error);
  if (!error) message += ", " + Megabytes(space.available) + " free";
  return {ErrorCode::kFileUnwritable,
          message + "; free up space, check the permissions, or write to another folder"};
}

FileReplacer::FileReplacer(const fs::path& target, bool overwrite)
    : target_(Resolved(target)), overwrite_(overwrite) {
  CheckTarget(target_, overwrite_);
  RemoveAbandoned(target_);
  temporary_ = CreateTemporary(target_);
}

FileReplacer::~FileReplacer() {
  if (committed_) return;
  std::error_code error;
  fs::remove(temporary_, error);
}

void FileReplacer::Commit() {
  const fs::path folder = FolderOf(target_);  // nothing may fail for lack of memory later
  if (overwrite_) CopyPermissions(target_, temporary_);
  if (!Flush(temporary_, O_RDONLY)) {
    const std::string cause = std::strerror(errno);
    std::error_code error;
    const uintmax_t bytes = fs::file_size(temporary_, error);
    const int64_t needed = error ? 0 : static_cast<int64_t>(bytes);
    fs::remove(temporary_, error);  // so that what is free is all that is
    throw UnwritableError(target_, cause, needed);
  }
  const bool renamed = overwrite_ ? std::rename(temporary_.c_str(), target_.c_str()) == 0
                                  : RenameOntoNothing(temporary_, target_);
  if (!renamed) {
    if (errno == EEXIST) ThrowExists(target_);
    throw UnwritableError(target_, std::strerror(errno), 0);
  }
  committed_ = true;
  // The file is in place by now: a file system that can't flush a folder is no reason to fail.
  Flush(folder, O_RDONLY | O_DIRECTORY);
}

}  // namespace waystone
