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
#include <cstring>
#include <iterator>
#include <string_view>
#include <utility>
#include <vector>

#include "api/logged_query.h"
#include "core/base/error.h"
#include "schema/file/file_replacer.h"
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
    std::error_code ignored;  // of a dangling link
    const fs::path file = folder / name;
    if (fs::is_regular_file(file, ignored)) {
      bytes += static_cast<int64_t>(fs::file_size(file, ignored));
    }
  }
  return bytes;
}

// Creates the folder, accessible to its owner only from the first moment.
void MakePrivateFolder(const fs::path& folder) {
  std::error_code ignored;  // what can't be created can't be written to either
  const fs::path whole = fs::absolute(folder).lexically_normal();
  const fs::path path = whole.has_filename() ? whole : whole.parent_path();
  fs::create_directories(path.parent_path(), ignored);
  if (mkdir(path.c_str(), S_IRWXU) == 0) chmod(path.c_str(), S_IRWXU);  // whatever the umask
}

constexpr mode_t kOwner = S_IRUSR | S_IWUSR;

// Opens a file that only its owner may read and write, whatever the umask and the folder's
// permissions; not through a link that somebody else put there.
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

// Removes what a killed program left of images.
void RemoveParts(const fs::path& folder) {
  for (const std::string& name : FolderEntries(folder)) {
    std::error_code ignored;
    if (name.starts_with(kPartName)) fs::remove(folder / name, ignored);
  }
}

// Removes the part of a line that a killed program wrote: the next line would be appended to it,
// and its query can't be asked again.
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

// Appends the whole line or nothing: the next one would be appended to a part.
void AppendLine(const fs::path& path, std::string_view line) {
  const FileDescriptor file = OpenPrivate(path, O_WRONLY | O_APPEND);
  struct stat before = {};
  if (!file.is_open() || fstat(file.get(), &before) != 0) {
    throw UnwritableError(path, std::strerror(errno), 0);
  }
  if (WriteAll(file, line)) return;
  const int cause = errno;
  // If even this fails on a disk that was just full, nothing can be done.
  [[maybe_unused]] const int undone = ftruncate(file.get(), before.st_size);
  throw UnwritableError(path, std::strerror(cause), std::ssize(line));
}

}  // namespace

// Images that a query added to the folder: removed unless its line is written.
class QueryLog::NewImages {
 public:
  explicit NewImages(size_t most) { paths_.reserve(most); }
  ~NewImages() {
    for (const fs::path& path : paths_) unlink(path.c_str());
  }
  NewImages(const NewImages&) = delete;
  NewImages& operator=(const NewImages&) = delete;

  void Add(fs::path path, int64_t bytes) noexcept {
    paths_.push_back(std::move(path));
    bytes_ += bytes;
  }
  void Keep() { paths_.clear(); }
  int64_t bytes() const { return bytes_; }

 private:
  std::vector<fs::path> paths_;
  int64_t bytes_ = 0;
};

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
    files.push_back(Sha256Hex(image.bytes) + ".image");
  }
  const std::string line =
      Dump(LoggedQueryJson({id, map, request, answer}, SecondsSinceEpoch(), files)) + "\n";
  try {
    const std::lock_guard lock(mutex_);
    Write(request, files, line);
  } catch (const MapError& error) {
    on_error_(std::string("a query is left out of the query log: ") + error.what());
  }
}

void QueryLog::Write(const QueryRequest& request, const std::vector<std::string>& files,
                     const std::string& line) {
  NewImages images(files.size());
  for (size_t i = 0; i < files.size(); ++i) Store(request.images[i].bytes, files[i], images);
  AppendLine(folder_ / kQueryLogLines, line);
  images.Keep();
  Count(images.bytes() + std::ssize(line));
}

void QueryLog::Store(const std::string& bytes, const std::string& file, NewImages& images) {
  fs::path path = folder_ / file;
  struct stat there = {};
  const bool is_new = lstat(path.c_str(), &there) != 0;
  if (!is_new && S_ISREG(there.st_mode) && there.st_size == std::ssize(bytes)) return;
  std::string part = (folder_ / kPartName).string() + "XXXXXX";
  const FileDescriptor out(mkostemp(part.data(), O_CLOEXEC));
  if (out.is_open()) fchmod(out.get(), kOwner);  // whatever the umask
  if (!WriteAll(out, bytes) || std::rename(part.c_str(), path.c_str()) != 0) {
    const int cause = errno;
    if (out.is_open()) unlink(part.c_str());
    throw UnwritableError(path, std::strerror(cause), std::ssize(bytes));
  }
  if (is_new) images.Add(std::move(path), std::ssize(bytes));  // else it is an earlier query's
}

}  // namespace waystone
