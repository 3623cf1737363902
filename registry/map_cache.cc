// SPDX-License-Identifier: Apache-2.0
#include "registry/map_cache.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <system_error>
#include <tuple>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "schema/file/file_replacer.h"
#include "schema/file/folder_entries.h"
#include "schema/file/sha256.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr const char* kWhole = ".db";
constexpr const char* kPart = ".part";
constexpr const char* kHashPrefix = "sha256:";
constexpr double kBytesPerMb = 1e6;

std::string DigitsOf(const std::string& sha256) { return sha256.substr(std::strlen(kHashPrefix)); }

std::string MbText(int64_t bytes) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f MB", static_cast<double>(bytes) / kBytesPerMb);
  return text;
}

MapError NoRoom(const std::string& message) { return {ErrorCode::kNoRoom, message}; }

MapError NotReady(const std::string& message) { return {ErrorCode::kNotReady, message}; }

MapError Stopping() { return NotReady("the server is shutting down"); }

// Whether removing other files may help.
bool IsFull(int cause) { return cause == ENOSPC || cause == EDQUOT; }

// A file of the cache, by its name; nothing for other files.
struct CachedName {
  std::string sha256;
  bool whole = false;
};
std::optional<CachedName> ParseName(const std::string& name) {
  for (const bool whole : {true, false}) {
    const std::string extension = whole ? kWhole : kPart;
    if (!name.ends_with(extension)) continue;
    const std::string sha256 = kHashPrefix + name.substr(0, name.size() - extension.size());
    if (IsSha256(sha256)) return CachedName{sha256, whole};
  }
  return std::nullopt;
}

int64_t SizeOf(const fs::path& path) {
  std::error_code error;
  const uintmax_t bytes = fs::file_size(path, error);
  return error ? 0 : static_cast<int64_t>(bytes);
}

std::string HashOfPart(const fs::path& part) {
  try {
    return Sha256OfFile(part);
  } catch (const MapError& error) {  // somebody removed it
    throw NotReady(error.what());
  }
}

}  // namespace

// A file being copied: appends what comes, and makes room when the disk is full.
class MapCache::PartFile : public FileSink {
 public:
  PartFile(MapCache& cache, fs::path path, int64_t bytes)
      : cache_(cache), path_(std::move(path)), bytes_(bytes) {
    file_ = open(path_.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
    if (file_ < 0) Fail(errno);
  }
  ~PartFile() override { close(file_); }
  PartFile(const PartFile&) = delete;
  PartFile& operator=(const PartFile&) = delete;

  void Begin(int64_t offset) override {
    const bool placed = ftruncate(file_, offset) == 0 && lseek(file_, offset, SEEK_SET) == offset;
    if (!placed) Fail(errno);
  }

  bool Take(std::span<const char> bytes) override {
    while (!bytes.empty()) {
      if (cache_.Stopped()) return false;
      const ssize_t written = write(file_, bytes.data(), bytes.size());
      if (written > 0) {
        bytes = bytes.subspan(static_cast<size_t>(written));
      } else if (IsFull(errno)) {
        const int cause = errno;
        const std::lock_guard lock(cache_.mutex_);
        if (!cache_.EvictOne()) Fail(cause);
      } else if (errno != EINTR) {
        Fail(errno);
      }
    }
    return true;
  }

  void Flush() {
    if (fsync(file_) != 0) Fail(errno);
  }

 private:
  [[noreturn]] void Fail(int cause) const {
    const std::string why = std::strerror(cause);
    const std::string message = UnwritableError(path_, why, bytes_).what();
    // A bound on the size of files has no room for this one, either.
    if (!IsFull(cause) && cause != EFBIG) throw NotReady(message);
    throw FullDiskError(message, "the map's file can't be written: " + why + ", " + MbText(bytes_) +
                                     " required; the server's log says more");
  }

  MapCache& cache_;
  fs::path path_;
  int64_t bytes_;
  int file_ = -1;
};

MapCache::MapCache(const fs::path& folder, int64_t max_bytes)
    : folder_(folder), max_bytes_(max_bytes) {
  const std::lock_guard lock(mutex_);
  TakeFolder();
}

MapCache::~MapCache() = default;

void MapCache::TakeFolder() {
  lock_ = nullptr;  // first: where files have no lasting numbers, it may be the same file
  lock_ = std::make_unique<CacheLock>(folder_);
  Scan();
}

void MapCache::Restore() {
  const std::lock_guard lock(mutex_);
  RestoreFolder();
}

void MapCache::RestoreFolder() {
  if (lock_ && lock_->Holds()) return;
  try {
    TakeFolder();
  } catch (const MapError& error) {
    throw NotReady(error.what());
  }
}

// Takes the files that an earlier server left, or that are left of ours, in the order of their last
// use.
void MapCache::Scan() {
  std::vector<std::tuple<fs::file_time_type, std::string, Entry>> found;
  std::error_code ignored;
  for (const std::string& name : FolderEntries(folder_)) {
    const std::optional<CachedName> cached = ParseName(name);
    if (!cached) continue;
    const fs::path path = folder_ / name;
    Entry entry;
    entry.bytes = SizeOf(path);
    entry.whole = cached->whole;
    found.emplace_back(fs::last_write_time(path, ignored), cached->sha256, entry);
  }
  std::ranges::sort(
      found, {}, [](const auto& file) { return std::pair(std::get<0>(file), std::get<1>(file)); });
  for (auto& [sha256, entry] : entries_) {
    if (!entry.copying) entry.SetGone();
  }
  std::erase_if(entries_, [](const auto& entry) { return entry.second.IsNothing(); });
  for (const auto& [time, sha256, entry] : found) {
    Entry& known = entries_[sha256];
    if (known.copying) continue;
    if (known.whole) {  // and a part that is no longer needed
      fs::remove(PartOf(sha256), ignored);
      continue;
    }
    if (entry.whole && known.bytes > 0) fs::remove(PartOf(sha256), ignored);
    known.bytes = entry.bytes;
    known.whole = entry.whole;
    known.last_use = ++uses_;
  }
  MakeRoom("", 0);  // the bound may be smaller than it was
}

fs::path MapCache::PathOf(const std::string& sha256) const {
  return folder_ / (DigitsOf(sha256) + kWhole);
}
fs::path MapCache::PartOf(const std::string& sha256) const {
  return folder_ / (DigitsOf(sha256) + kPart);
}

bool MapCache::Stopped() const {
  const std::lock_guard lock(mutex_);
  return stopped_;
}

MapCache::FilePtr MapCache::Use(const std::string& sha256, Entry& entry) {
  entry.last_use = ++uses_;
  // For the next server: nothing else records the order of uses. Not while somebody reads the file,
  // to whom a new time would look like a write.
  if (entry.users == 0) utimensat(AT_FDCWD, PathOf(sha256).c_str(), nullptr, 0);
  FilePtr file = std::make_shared<const File>(this, sha256);
  ++entry.users;
  return file;
}

void MapCache::Release(const std::string& sha256) {
  const std::lock_guard lock(mutex_);
  const auto it = entries_.find(sha256);
  if (it == entries_.end()) return;
  --it->second.users;
  if (it->second.IsNothing()) entries_.erase(it);
}

// The entry of a whole file that is there; forgets one that somebody removed or truncated.
MapCache::Entry* MapCache::WholeEntry(const std::string& sha256) {
  const auto it = entries_.find(sha256);
  if (it == entries_.end() || !it->second.whole) return nullptr;
  if (SizeOf(PathOf(sha256)) == it->second.bytes) return &it->second;
  Discard(sha256);
  return nullptr;
}

MapCache::FilePtr MapCache::Find(const std::string& sha256) {
  const std::lock_guard lock(mutex_);
  Entry* entry = WholeEntry(sha256);
  return entry ? Use(sha256, *entry) : nullptr;
}

MapCache::FilePtr MapCache::Get(const Store& store, const std::string& sha256, int64_t bytes) {
  std::unique_lock lock(mutex_);
  while (true) {
    if (stopped_) throw Stopping();
    const auto it = entries_.find(sha256);
    if (it == entries_.end() || !it->second.copying) break;
    changed_.wait(lock);
  }
  if (Entry* whole = WholeEntry(sha256); whole && whole->bytes == bytes) {
    return Use(sha256, *whole);
  }
  Discard(sha256);  // not the file of that hash: it was truncated or changed
  RestoreFolder();
  MakeRoom(sha256, bytes);
  Entry& entry = entries_[sha256];
  entry.bytes = bytes;
  entry.copying = true;
  entry.last_use = ++uses_;
  lock.unlock();
  try {
    Copy(store, sha256, bytes);
  } catch (...) {
    lock.lock();
    CountCopy(sha256, false);
    throw;
  }
  lock.lock();
  CountCopy(sha256, true);
  return Use(sha256, entries_.at(sha256));
}

void MapCache::CountCopy(const std::string& sha256, bool good) {
  const auto it = entries_.find(sha256);
  it->second.copying = false;
  it->second.whole = good;
  if (good) {
    ++counted_.fetched_files;
    counted_.fetched_bytes += it->second.bytes;
  } else {
    ++counted_.failed_fetches;
    it->second.bytes = SizeOf(PartOf(sha256));
    if (it->second.IsNothing()) entries_.erase(it);
  }
  changed_.notify_all();
}

void MapCache::Copy(const Store& store, const std::string& sha256, int64_t bytes) {
  const bool resumed = SizeOf(PartOf(sha256)) > 0;
  if (CopyOnce(store, sha256, bytes)) return;
  // The bytes of an earlier attempt may have been damaged by a loss of power.
  if (resumed && CopyOnce(store, sha256, bytes)) return;
  throw MapError(ErrorCode::kStoreDamaged,
                 "the store's file " + StorePath(sha256) +
                     " has other bytes than those that were published (SHA-256 differs); restore "
                     "it in the store, or publish the map again");
}

bool MapCache::CopyOnce(const Store& store, const std::string& sha256, int64_t bytes) {
  const fs::path part = PartOf(sha256);
  int64_t there = SizeOf(part);
  if (there > bytes) there = 0;
  {
    PartFile file(*this, part, bytes);
    if (there < bytes) {
      store.Fetch(sha256, there, bytes, file);
      if (Stopped()) throw Stopping();
    }
    file.Flush();
  }
  std::error_code error;
  if (HashOfPart(part) != sha256) {
    fs::remove(part, error);
    if (error) throw NotReady(UnwritableError(part, error.message(), 0).what());
    return false;
  }
  fs::rename(part, PathOf(sha256), error);
  if (error) throw NotReady(UnwritableError(PathOf(sha256), error.message(), 0).what());
  return true;
}

void MapCache::MakeRoom(const std::string& sha256, int64_t bytes) {
  const auto used = [&] {
    int64_t sum = 0;
    for (const auto& [hash, entry] : entries_) sum += hash == sha256 ? 0 : entry.bytes;
    return sum;
  };
  if (bytes > max_bytes_) {
    throw NoRoom("the map's file has " + MbText(bytes) + ", the cache may hold " +
                 MbText(max_bytes_) + "; give it more room (--cache-size)");
  }
  while (used() + bytes > max_bytes_) {
    if (EvictOne()) continue;
    if (bytes == 0) return;
    throw NoRoom("the cache is full of files that are in use: " + MbText(used()) + " of " +
                 MbText(max_bytes_) + ", " + MbText(bytes) +
                 " required; give it more room (--cache-size)");
  }
}

bool MapCache::EvictOne() {
  auto oldest = entries_.end();
  for (auto it = entries_.begin(); it != entries_.end(); ++it) {
    const Entry& entry = it->second;
    if (entry.users > 0 || entry.copying) continue;
    if (oldest == entries_.end() || entry.last_use < oldest->second.last_use) oldest = it;
  }
  if (oldest == entries_.end()) return false;
  std::error_code ignored;
  fs::remove(PathOf(oldest->first), ignored);
  fs::remove(PartOf(oldest->first), ignored);
  entries_.erase(oldest);
  return true;
}

void MapCache::Drop(const std::string& sha256) {
  const std::lock_guard lock(mutex_);
  Discard(sha256);
}

void MapCache::Discard(const std::string& sha256) {
  const auto it = entries_.find(sha256);
  if (it == entries_.end() || !it->second.whole) return;
  std::error_code ignored;
  fs::remove(PathOf(sha256), ignored);
  it->second.SetGone();
  if (it->second.IsNothing()) entries_.erase(it);
}

void MapCache::Stop() {
  const std::lock_guard lock(mutex_);
  stopped_ = true;
  changed_.notify_all();
}

MapCache::Usage MapCache::usage() const {
  const std::lock_guard lock(mutex_);
  Usage usage = counted_;
  for (const auto& [sha256, entry] : entries_) {
    usage.files += entry.whole ? 1 : 0;
    usage.bytes += entry.bytes;
  }
  return usage;
}

}  // namespace waystone
