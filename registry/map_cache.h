// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "registry/cache_lock.h"
#include "registry/store.h"

namespace waystone {

// A disk without room for a file, which the message names by its path.
class FullDiskError : public MapError {
 public:
  FullDiskError(const std::string& message, std::string told)
      : MapError(ErrorCode::kNoRoom, message), told_(std::move(told)) {}

  // The same for clients: without the path.
  const std::string& told() const { return told_; }

 private:
  std::string told_;
};

// A folder of map files named by their hashes, copied from a store when they are needed. It holds a
// bounded number of bytes: the least recently used files that aren't in use are removed to make
// room. Whole files are "<64 hex digits>.db", incomplete ones "<64 hex digits>.part"; an
// interrupted copy resumes where it stopped, even after a restart. Only one process at a time can
// have a cache. Files may be deleted by others, and so may the whole folder: what is missing is
// copied again. Thread-safe.
class MapCache {
 public:
  // A file in the cache, which isn't removed while this object exists. The cache must outlive it.
  class File {
   public:
    File(MapCache* cache, std::string sha256) : cache_(cache), sha256_(std::move(sha256)) {}
    ~File() { cache_->Release(sha256_); }
    File(const File&) = delete;
    File& operator=(const File&) = delete;

    std::filesystem::path path() const { return cache_->PathOf(sha256_); }

   private:
    MapCache* cache_;
    std::string sha256_;
  };
  using FilePtr = std::shared_ptr<const File>;

  // Creates the folder if it is missing. Throws MapError(kFileUnwritable), also for a cache that
  // another process has.
  MapCache(const std::filesystem::path& folder, int64_t max_bytes);
  ~MapCache();
  MapCache(const MapCache&) = delete;
  MapCache& operator=(const MapCache&) = delete;

  const std::filesystem::path& folder() const { return folder_; }

  // The file of that hash and size, copied from the store unless the cache has it. Of several
  // threads that want the same file, one copies it and the others wait. Throws what the store
  // throws, and MapError: kStoreDamaged where the store's bytes don't match the hash; kNoRoom for a
  // file larger than the cache and a cache full of files in use; FullDiskError; kNotReady where the
  // folder can't be written to for another reason, and after Stop(). What arrived before the store
  // failed is kept for the next attempt.
  FilePtr Get(const Store& store, const std::string& sha256, int64_t bytes);
  // The same without a store: null unless the cache has the file.
  FilePtr Find(const std::string& sha256);
  // Makes the folder again, and locks it, if somebody removed it; Get() does so, too. Throws
  // MapError(kNotReady), also for a folder that another process has taken meanwhile.
  void Restore();
  // Forgets a file whose bytes turned out to be wrong; the next Get() copies it again.
  void Drop(const std::string& sha256);
  // Ends the copies in progress, and all later ones, with MapError(kNotReady).
  void Stop();

  struct Usage {
    int64_t files = 0;          // complete ones
    int64_t bytes = 0;          // of all files, with what is reserved for copies in progress
    int64_t fetched_files = 0;  // these three: since the cache was opened
    int64_t fetched_bytes = 0;
    int64_t failed_fetches = 0;
  };
  Usage usage() const;
  int64_t max_bytes() const { return max_bytes_; }

 private:
  struct Entry {
    int64_t bytes = 0;
    uint64_t last_use = 0;
    int users = 0;
    bool whole = false;
    bool copying = false;

    void SetGone() {
      bytes = 0;
      whole = false;
    }
    // Whether there is nothing to remember: no file, and nobody who uses or copies it.
    bool IsNothing() const { return bytes == 0 && users == 0 && !whole && !copying; }
  };
  class PartFile;
  friend class PartFile;

  std::filesystem::path PathOf(const std::string& sha256) const;
  std::filesystem::path PartOf(const std::string& sha256) const;
  void TakeFolder();  // these eight: with the mutex locked
  void RestoreFolder();
  void Scan();
  FilePtr Use(const std::string& sha256, Entry& entry);
  Entry* WholeEntry(const std::string& sha256);
  void Discard(const std::string& sha256);
  void MakeRoom(const std::string& sha256, int64_t bytes);
  bool EvictOne();
  void Release(const std::string& sha256);
  void Copy(const Store& store, const std::string& sha256, int64_t bytes);
  // Whether the bytes that came are those of the hash.
  bool CopyOnce(const Store& store, const std::string& sha256, int64_t bytes);
  void CountCopy(const std::string& sha256, bool good);  // with the mutex locked
  bool Stopped() const;

  std::filesystem::path folder_;
  int64_t max_bytes_;
  std::unique_ptr<CacheLock> lock_;  // null while the folder can't be had
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::string, Entry> entries_;  // by hash; of complete and incomplete files
  uint64_t uses_ = 0;
  bool stopped_ = false;
  Usage counted_;
};

}  // namespace waystone
