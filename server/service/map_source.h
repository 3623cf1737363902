// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "api/json.h"
#include "core/base/error.h"
#include "localizer/coarse/coarse_index.h"
#include "localizer/query.h"
#include "server/service/coarse_maps.h"
#include "server/service/query_gate.h"
#include "server/service/served_map.h"

namespace waystone {

// What a server that serves from a registry holds. Bytes are of map files, except memory's.
struct RegistryHoldings {
  bool connected = false;    // the registry answered when last asked
  double silent_s = 0;       // since it answered
  int64_t memory_bytes = 0;  // what open maps count as, and its bound
  int64_t memory_limit = 0;
  int64_t cached_files = 0;
  int64_t cached_bytes = 0;
  int64_t cache_limit = 0;
  int64_t fetched_files = 0;  // these and the following: since the start
  int64_t fetched_bytes = 0;
  int64_t failed_fetches = 0;
  int64_t opened = 0;
  int64_t closed = 0;   // to make room in memory
  int64_t swapped = 0;  // open maps replaced by another version
  int64_t refused = 0;  // versions that couldn't be fetched or opened
  CoarseHoldings coarse;
};

// The maps that a query of all maps is to ask.
struct SearchScope {
  std::vector<std::string> names;  // those that fit the hints, ascending
  // Proposes some of them; null where all of them can be asked.
  std::shared_ptr<const CoarseIndex> coarse;
  int unindexed = 0;  // of the names, not in the index
};

// A map that was to be opened for a query, and what became of it.
enum class MapFinding { kFound, kLate, kFailed, kTooLarge };
struct FoundMap {
  std::string name;
  std::shared_ptr<const ServedMap> map;  // null unless it was found
  MapFinding finding = MapFinding::kFailed;
  std::string error;  // then, one line
  ErrorCode code = ErrorCode::kNotReady;
};

// A map was still being fetched or opened when the wait for it ended.
class MapLate : public MapError {
 public:
  explicit MapLate(const std::string& message) : MapError(ErrorCode::kNotReady, message) {}
};

// What a server holds at the moment.
struct Holdings {
  size_t maps = 0;  // by name
  size_t open = 0;  // of them, in memory
  std::optional<RegistryHoldings> registry;
};

// The maps of a server by their names. A request keeps the maps that it found, whatever becomes of
// the names meanwhile. Thread-safe.
class MapSource {
 public:
  using MapPtr = std::shared_ptr<const ServedMap>;
  using Deadline = QueryGate::Deadline;

  virtual ~MapSource() = default;

  // Ascending.
  virtual std::vector<std::string> Names() const = 0;
  // Throws MapError(kNotFound) for a name that isn't served. Doesn't wait.
  virtual void CheckName(const std::string& name) const = 0;
  // One of the maps. May wait until it is open, at most until the deadline. Throws BusyError, and
  // MapError: kNotFound; for a map that can't be had now kNotReady, kStoreUnavailable,
  // kStoreDamaged, kNoRoom, or what is wrong with its file.
  virtual MapPtr Find(const std::string& name, const Deadline& deadline) = 0;
  // What a query of all maps with these hints asks. Doesn't wait. Throws MapError: kNotFound where
  // no map fits the hints, kNotReady where there is no map, and kNotAvailable where the maps that
  // fit are too many to be asked at once and none of them can be proposed.
  virtual SearchScope ScopeOf(const MapHints& hints) const = 0;
  // The first of these maps, at least one: as many as can be had at the same time. Waits as Find
  // does, and throws nothing but std::bad_alloc. `names` isn't empty.
  virtual std::vector<FoundMap> FindLot(std::span<const std::string> names,
                                        const Deadline& deadline) = 0;
  // What lists say of a map (MapJson). Doesn't wait. Throws MapError(kNotFound).
  virtual Json Summary(const std::string& name) const = 0;
  virtual Holdings holdings() const = 0;
  // Ends the waits of Find and FindLot, now and from now on, with MapError(kNotReady).
  virtual void EndWaits() {}
};

}  // namespace waystone
