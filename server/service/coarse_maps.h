// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/base/clock.h"
#include "localizer/coarse/coarse_index.h"
#include "registry/map_cache.h"
#include "registry/map_version.h"

namespace waystone {

// What a server holds of its registry's coarse index.
struct CoarseHoldings {
  int64_t maps = 0;      // in the index
  int64_t places = 0;    // of them
  int64_t bytes = 0;     // of memory
  int64_t without = 0;   // maps that were published without an entry
  int64_t waiting = 0;   // maps whose entry isn't there yet
  int64_t left_out = 0;  // of these: no room in memory
  int64_t refused = 0;   // since the start: entries that couldn't be fetched or read
};

// The coarse entries of a registry's maps, all in memory: fetched from the store by a thread of its
// own, and made into an index whenever some have changed. While a new entry can't be had, the one
// before stays; it is tried again. Thread-safe.
class CoarseMaps {
 public:
  using Log = std::function<void(const std::string&)>;
  using StoreNow = std::function<std::shared_ptr<const Store>()>;

  // `folder` is a cache for these entries only. Entries that would exceed max_bytes of memory are
  // left out. Throws as MapCache does.
  CoarseMaps(const std::filesystem::path& folder, int64_t max_bytes, StoreNow store, Log log);
  ~CoarseMaps();

  // From now on entries are fetched.
  void Start();
  // Waits until what is under way has ended.
  void Stop();

  // What the registry says of a map: the version of its file, and which file in the store is its
  // entry, if it has one.
  void Set(const std::string& name, const std::string& map_version,
           const std::optional<CoarseFile>& file);
  void Forget(const std::string& name);
  // Tries again at once what has failed.
  void Retry();

  // Never null.
  std::shared_ptr<const CoarseIndex> index() const;
  CoarseHoldings holdings() const;

 private:
  struct Entry {
    std::string map_version;
    std::optional<CoarseFile> wanted;
    CoarseFile held_file;
    std::shared_ptr<const CoarseEntry> held;
    bool left_out = false;
    std::string error;
    int failures = 0;  // in a row
    Clock::time_point retry_at;

    bool IsHeld() const { return held && wanted == held_file; }
  };
  struct Wanted {
    std::string name;
    std::string map_version;
    CoarseFile file;
  };

  void KeepFetching();
  void FetchWanted();
  bool IsStopped() const;
  std::vector<Wanted> ListWanted();  // with the lock held
  void Fetch(const Wanted& wanted);
  std::shared_ptr<const CoarseEntry> Read(const Wanted& wanted);
  void Take(const Wanted& wanted, std::shared_ptr<const CoarseEntry> entry,
            const std::string& error);
  void Rebuild();
  void TellWithout();

  MapCache cache_;
  int64_t max_bytes_;
  StoreNow store_;
  Log log_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::string, Entry> entries_;
  std::shared_ptr<const CoarseIndex> index_ = std::make_shared<const CoarseIndex>();
  int64_t held_bytes_ = 0;
  int64_t refused_ = 0;
  int64_t told_without_ = 0;
  bool index_is_old_ = false;
  bool stopped_ = false;
  std::thread thread_;
};

}  // namespace waystone
