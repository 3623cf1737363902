// SPDX-License-Identifier: Apache-2.0
#include "server/service/query_log.h"

#include <fcntl.h>
#include <openssl/sha.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "api/logged_query.h"
#include "core/base/error.h"
#include "schema/file/folder_entries.h"
#include "server/http/file_descriptor.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

std::string Sha256Hex(const std::string& bytes) {
  std::array<unsigned char, SHA256_DIGEST_LENGTH> digest{};
  SHA256(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(), digest.data());
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string hex;
  for (const unsigned char byte : digest) hex += {kDigits[byte >> 4], kDigits[byte & 15]};
  return hex;
}

double SecondsSinceEpoch() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

int64_t BytesIn(const fs::path& folder) {
  int64_t bytes = 0;
  for (const std::string& name : FolderEntries(folder)) {
    std::error_code ignored;  // of a link that leads nowhere
    const fs::path file = folder / name;
    if (fs::is_regular_file(file, ignored)) {
      bytes += static_cast<int64_t>(fs::file_size(file, ignored));
    }
  }
  return bytes;
}

// Makes the folder for its owner alone, from its first moment on.
void MakePrivateFolder(const fs::path& folder) {
  std::error_code ignored;  // what can't be made can't be written to either
  const fs::path whole = fs::absolute(folder).lexically_normal();
  const fs::path path = whole.has_filename() ? whole : whole.parent_path();
  fs::create_directories(path.parent_path(), ignored);
  if (mkdir(path.c_str(), S_IRWXU) == 0) chmod(path.c_str(), S_IRWXU);  // whatever the umask
}

constexpr mode_t kOwner = S_IRUSR | S_IWUSR;

// Opens a file that its owner alone may read and write, whatever the umask and the folder's rights;
// none through a link that somebody else put there.
FileDescriptor OpenPrivate(const fs::path& path, int flags) {
  FileDescriptor file(open(path.c_str(), O_CREAT | O_CLOEXEC | O_NOFOLLOW | flags, kOwner));
  if (file.is_open() && fchmod(file.get(), kOwner) != 0) file.Close();
  return file;
}

bool WriteAll(const FileDescriptor& file, std::string_view bytes) {
  while (file.is_open() && !bytes.empty()) {
    const ssize_t written = write(file.get(), bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes.remove_prefix(static_cast<size_t>(written));
  }
  return file.is_open();
}

constexpr const char* kPartName = ".part-";  // of images that are being written

// What a program that was killed left of images.
void RemoveParts(const fs::path& folder) {
  for (const std::string& name : FolderEntries(folder)) {
    std::error_code ignored;
    if (name.starts_with(kPartName)) fs::remove(folder / name, ignored);
  }
}

// Takes back the part of a line that a program that was killed wrote: the next line would be glued
// to it, and nobody can ask it again.
bool RemoveTornLine(const fs::path& path) {
  const FileDescriptor file = OpenPrivate(path, O_RDWR);
  struct stat status = {};
  if (!file.is_open() || fstat(file.get(), &status) != 0) return false;
  off_t end = status.st_size;
  for (char last = 0; end > 0; --end) {
    if (pread(file.get(), &last, 1, end - 1) != 1) return false;
    if (last == '\n') break;
  }
  return end == status.st_size || ftruncate(file.get(), end) == 0;
}

// All of the line or nothing: the next one would be glued to a part.
bool AppendLine(const fs::path& path, std::string_view line) {
  const FileDescriptor file = OpenPrivate(path, O_WRONLY | O_APPEND);
  struct stat before = {};
  if (!file.is_open() || fstat(file.get(), &before) != 0) return false;
  if (WriteAll(file, line)) return true;
  // What a disk that was just full doesn't even take back, nobody can help.
  [[maybe_unused]] const int undone = ftruncate(file.get(), before.st_size);
  return false;
}

}  // namespace

QueryLog::QueryLog(fs::path folder, int64_t max_bytes,
                   std::function<void(const std::string&)> on_error)
    : folder_(std::move(folder)), max_bytes_(max_bytes), on_error_(std::move(on_error)) {
  MakePrivateFolder(folder_);
  if (!RemoveTornLine(folder_ / kQueryLogLines)) {
    throw MapError(ErrorCode::kFileUnwritable,
                   folder_.string() + " can't be written; choose another folder for --query-log");
  }
  RemoveParts(folder_);
  Count(BytesIn(folder_));
}

void QueryLog::Count(int64_t bytes) {
  const int64_t before = bytes_.fetch_add(bytes);
  if (before < max_bytes_ && before + bytes >= max_bytes_) {
    on_error_("the query log " + folder_.string() + " is full; further queries are not logged");
  }
}

void QueryLog::Add(const std::string& id, const Json& map, const QueryRequest& request,
                   const Json& answer) {
  if (bytes_ >= max_bytes_) return;
  std::vector<std::string> files;
  for (const QueryImage& image : request.images) {
    std::optional<std::string> file = Store(image.bytes);
    if (!file) return;  // `replay` couldn't ask this query again
    files.push_back(*std::move(file));
  }
  const std::string text =
      Dump(LoggedQueryJson({id, map, request, answer}, SecondsSinceEpoch(), files)) + "\n";
  {
    const std::lock_guard lock(mutex_);
    if (!AppendLine(folder_ / kQueryLogLines, text)) {
      return on_error_("the query log " + folder_.string() + " can't be written");
    }
  }
  Count(std::ssize(text));
}

std::optional<std::string> QueryLog::Store(const std::string& bytes) {
  std::string name = Sha256Hex(bytes) + ".image";
  const fs::path path = folder_ / name;
  struct stat there = {};
  if (lstat(path.c_str(), &there) == 0 && S_ISREG(there.st_mode) &&
      there.st_size == std::ssize(bytes)) {
    return name;
  }
  std::string part = (folder_ / kPartName).string() + "XXXXXX";
  const FileDescriptor file(mkostemp(part.data(), O_CLOEXEC));
  if (file.is_open()) fchmod(file.get(), kOwner);  // whatever the umask
  if (!WriteAll(file, bytes) || std::rename(part.c_str(), path.c_str()) != 0) {
    on_error_("an image of the query log " + folder_.string() + " can't be written");
    if (file.is_open()) unlink(part.c_str());
    return std::nullopt;
  }
  Count(std::ssize(bytes));
  return name;
}

}  // namespace waystone
