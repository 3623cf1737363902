// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "core/base/clock.h"
#include "core/base/error.h"
#include "registry/map_cache.h"
#include "registry/registry.h"
#include "server/http/file_descriptor.h"
#include "server/service/coarse_maps.h"
#include "server/service/map_memory.h"
#include "server/service/map_source.h"

namespace waystone {

struct RegistryMapsOptions {
  std::string registry;         // for OpenRegistry
  std::filesystem::path cache;  // a folder of this server alone
  std::string store;            // for OpenStore; empty: the one that the registry names
  int64_t memory_bytes = 4'000'000'000;
  int64_t cache_bytes = 20'000'000'000;
  double poll_s = 1;       // between looks at the registry
  double patience_s = 20;  // of a request, for maps to be opened
};

// The maps of a registry, fetched into a cache and opened when they are asked for, within a bound
// of memory: the least recently used ones are closed, and those of requests in progress end with
// them. A map counts as twice its file, with an appearance layer three times, and once more while
// it is opened. New versions of open maps are fetched and opened beside, and then take the place of
// the old ones at once; a version that can't be had leaves the one before. What is known of the
// registry is kept in the cache, so that a server goes on, and also starts, without the registry;
// without the store it serves what the cache has. Beside the maps it holds the coarse index of all
// of them, which may take a quarter of the memory on top. Thread-safe.
class RegistryMaps : public MapSource {
 public:
  using Log = std::function<void(const std::string&)>;

  // How many requests may wait for maps at once; further ones get BusyError.
  static constexpr int kMaxWaiting = 64;

  // Throws MapError: kFileUnreadable for a registry that can't be read while the cache knows
  // nothing of it, kFileUnwritable for a cache that can't be used or is another server's, kUsage.
  // `log` gets a line for each event, from any thread.
  RegistryMaps(const RegistryMapsOptions& options, Log log);
  ~RegistryMaps() override;  // waits until what is under way has ended

  std::vector<std::string> Names() const override;
  void CheckName(const std::string& name) const override;
  // Waits `patience_s` at most, as FindLot does for all maps together.
  MapPtr Find(const std::string& name, const Deadline& deadline) override;
  SearchScope ScopeOf(const MapHints& hints) const override;
  std::vector<FoundMap> FindLot(std::span<const std::string> names,
                                const Deadline& deadline) override;
  Json Summary(const std::string& name) const override;
  Holdings holdings() const override;
  void EndWaits() override;

  // Looks at the registry now, and tries again what has failed.
  void Refresh();

 private:
  // A map on its way, for all who wait for it.
  struct Opening {
    bool done = false;
    MapPtr map;         // null where it failed
    std::string error;  // then
    std::string told;   // of the error to clients, without paths; empty: the log says it
    ErrorCode code = ErrorCode::kNotReady;
  };
  struct Entry {
    MapVersion current;  // by the registry
    MapTraits traits;    // of `current`, as are these bytes
    int64_t open_bytes = 0;
    int64_t opening_bytes = 0;
    std::optional<MapVersion> served;  // what was opened last, perhaps an earlier version
    MapPtr open;
    int64_t bytes = 0;       // that `open` counts as
    MapCache::FilePtr file;  // of `open`: its file stays in the cache
    uint64_t last_use = 0;
    std::shared_ptr<Opening> opening;  // queued or under way
    std::string error;                 // why `current` isn't open
    std::string told;                  // of that to clients, as in Opening
    ErrorCode code = ErrorCode::kNotReady;
    int failures = 0;  // in a row
    Clock::time_point retry_at;

    // Whether `current` isn't to be tried again yet.
    bool MustWait() const { return failures > 0 && Clock::now() < retry_at; }
  };
  struct Opened {
    MapPtr map;
    int64_t bytes = 0;
    MapCache::FilePtr file;
  };
  using Lock = std::unique_lock<std::mutex>;

  bool ReadKnown();  // whether there is anything
  std::string TakeKnown();
  void WriteKnown();
  void Look();  // at the registry; throws what it throws
  void CheckId(const Registry& registry);
  void Apply(const RegistryNews& news);
  void ApplyState(const MapState& state);  // these six: with the lock held
  void SetCurrent(const MapVersion& version, Entry& entry);
  void Forget(const std::string& name);
  void QueueOpening(const std::string& name, Entry& entry);
  const Entry& EntryOf(const std::string& name) const;
  void MakeRoom(int64_t bytes);
  MapPtr CloseOldest(bool idle);  // with the lock held
  void QueueUpdates();
  void KeepLooking();
  void LookAgain();
  void KeepOpening();
  void OpenQueued(const std::string& name);
  Opened OpenVersion(const std::string& name, const MapVersion& version);
  std::shared_ptr<const MapIndex> ReadVersion(const MapVersion& version,
                                              const MapCache::FilePtr& file);
  std::shared_ptr<MapMemory::Share> TakeMemory(const MapVersion& version);
  void Finish(const std::string& name, const MapVersion& version, Opened opened,
              const Opening& failure, const std::optional<MapVersion>& tried_current);
  void GiveUp(const std::string& name);
  void Count(const Opening& failure, Entry& entry, std::string& said);  // with the lock held
  std::shared_ptr<const Store> StoreNow() const;
  static std::string Megabytes(int64_t bytes);
  Clock::time_point WaitUntil(const Deadline& deadline) const;
  // `yields`: the request has other maps, whose memory a map that is being opened may want; then
  // it gets nothing instead of waiting.
  MapPtr Find(const std::string& name, const Deadline& deadline, bool yields);
  std::optional<FoundMap> TryToFind(const std::string& name, const Deadline& deadline, bool yields);
  void Stop();

  RegistryMapsOptions options_;
  Log log_;
  std::shared_ptr<MapMemory> memory_;
  MapCache cache_;
  CoarseMaps coarse_;
  FileDescriptor wake_;  // readable when the looking thread shall look, or end
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::string, Entry> entries_;
  std::deque<std::string> queue_;  // of names to open
  std::string registry_id_;
  std::string registry_store_;
  std::shared_ptr<const Store> store_;
  uint64_t uses_ = 0;
  int64_t open_bytes_ = 0;
  int waiting_ = 0;
  bool serving_ = false;  // maps of the registry `registry_id_`, for good
  bool stopped_ = false;
  bool wants_room_ = false;  // a map that is being opened waits for memory
  bool ended_waits_ = false;
  bool connected_ = false;
  bool known_changed_ = false;  // since it was written
  Clock::time_point answered_ = Clock::now();
  RegistryHoldings counted_;
  std::mutex opening_;                  // one map is read at a time
  std::stop_source stop_;               // ends the wait for a database that doesn't answer
  std::unique_ptr<Registry> registry_;  // null while it can't be reached; of the looking thread
  Clock::time_point written_;           // when what is known was written
  std::string unwritten_;               // why it couldn't be, as it was logged
  std::vector<std::thread> threads_;
};

}  // namespace waystone
