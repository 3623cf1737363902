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

#include "registry/store.h"

namespace waystone {

// A folder of map files by their hash, copied from a store when they are needed. It holds a bounded
// number of bytes: the least recently used files that nobody uses make room. Whole files are
// "<64 hex digits>.db", those on their way "<64 hex digits>.part"; one that was interrupted goes on
// where it stopped, also after a restart. One process has a cache at a time. Thread-safe.
class MapCache {
 public:
  // A file of the cache, which stays there while this exists. The cache must outlive it.
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

  // Creates the folder where it isn't there. Throws MapError(kFileUnwritable), also for a cache
  // that another process has.
  MapCache(const std::filesystem::path& folder, int64_t max_bytes);
  ~MapCache();
  MapCache(const MapCache&) = delete;
  MapCache& operator=(const MapCache&) = delete;

  const std::filesystem::path& folder() const { return folder_; }

  // The file of that hash and size, copied from the store where the cache hasn't got it. Of several
  // threads that want the same file, one copies it. Throws what the store throws,
  // MapError(kStoreDamaged) for other bytes than those of the hash, and kNoRoom for a file larger
  // than the cache may be, a cache full of files in use, and a full disk. What came before an error
  // of the store is kept for the next time.
  FilePtr Get(const Store& store, const std::string& sha256, int64_t bytes);
  // The same without a store: nothing where the cache hasn't got it.
  FilePtr Find(const std::string& sha256);
  // Forgets a file whose bytes turned out to be others; the next Get() copies it again.
  void Drop(const std::string& sha256);
  // Ends copies that are under way, and all that would begin, with MapError(kNotReady).
  void Stop();

  struct Usage {
    int64_t files = 0;  // whole ones
    int64_t bytes = 0;  // of all files, and reserved for those on their way
    int64_t fetched_files = 0;
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
  };
  class PartFile;
  friend class PartFile;

  std::filesystem::path PathOf(const std::string& sha256) const;
  std::filesystem::path PartOf(const std::string& sha256) const;
  void Scan();
  FilePtr Use(const std::string& sha256, Entry& entry);  // with the lock held
  void Release(const std::string& sha256);
  void MakeRoom(const std::string& sha256, int64_t bytes);  // with the lock held
  bool EvictOne();                                          // with the lock held
  void Copy(const Store& store, const std::string& sha256, int64_t bytes);
  // Whether the bytes that came are those of the hash.
  bool CopyOnce(const Store& store, const std::string& sha256, int64_t bytes);
  void CountCopy(const std::string& sha256, bool good);  // with the lock held
  bool Stopped() const;

  std::filesystem::path folder_;
  int64_t max_bytes_;
  int lock_ = -1;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::string, Entry> entries_;  // by hash; of files that are there or on their way
  uint64_t uses_ = 0;
  bool stopped_ = false;
  Usage counted_;
};

}  // namespace waystone
