// SPDX-License-Identifier: Apache-2.0
// Which maps of its registry RegistryMaps lets a query of all maps ask, and how it opens them.
#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "server/service/registry_maps.h"

namespace waystone {
namespace {

// Whether a box comes within the radius of a point, by the coordinates that both have.
bool IsWithin(const MapTraits& traits, const PositionHint& position) {
  if (traits.frame != position.frame) return false;
  double square = 0;
  for (size_t i = 0; i < std::min(position.at.size(), traits.min.size()); ++i) {
    const double outside =
        position.at[i] - std::clamp(position.at[i], std::min(traits.min[i], traits.max[i]),
                                    std::max(traits.min[i], traits.max[i]));
    square += outside * outside;
  }
  return square <= position.radius * position.radius;
}

bool Fits(const MapTraits& traits, const MapHints& hints) {
  const bool tagged = std::ranges::all_of(
      hints.tags, [&](const std::string& tag) { return std::ranges::count(traits.tags, tag) > 0; });
  return tagged && (!hints.position || IsWithin(traits, *hints.position));
}

}  // namespace

SearchScope RegistryMaps::ScopeOf(const MapHints& hints) const {
  SearchScope scope;
  int64_t bytes = 0;
  size_t count = 0;
  std::set<std::string> fitting;
  {
    const std::lock_guard lock(mutex_);
    if (entries_.empty()) throw MapError(ErrorCode::kNotReady, "no maps in the registry");
    count = entries_.size();
    int64_t largest = 0;
    for (const auto& [name, entry] : entries_) {
      if (name != hints.previous_map && !Fits(entry.traits, hints)) continue;
      fitting.insert(fitting.end(), name);
      bytes += entry.open_bytes;
      largest = std::max(largest, entry.current.bytes);
    }
    bytes += largest;
  }
  if (fitting.empty()) {
    throw MapError(ErrorCode::kNotFound, "none of the " + std::to_string(count) +
                                             " maps fits the hints; ask with fewer of them");
  }
  scope.names.assign(fitting.begin(), fitting.end());
  if (bytes <= memory_->limit()) return scope;
  scope.coarse = coarse_.index();
  const std::vector<CoarseIndex::Map>& indexed = scope.coarse->maps();
  const auto known = std::ranges::count_if(
      indexed, [&](const CoarseIndex::Map& map) { return fitting.contains(map.name); });
  scope.unindexed = static_cast<int>(std::ssize(fitting) - known);
  if (known > 0) return scope;
  throw MapError(ErrorCode::kNotAvailable,
                 "all " + std::to_string(scope.names.size()) +
                     " maps together take more than the " + Megabytes(memory_->limit()) +
                     " of memory that are allowed, and none of them is in the coarse index; name "
                     "the map (/v1/maps/{map}/localize), or publish the maps again");
}

std::optional<FoundMap> RegistryMaps::TryToFind(const std::string& name, const Deadline& deadline,
                                                bool yields) {
  FoundMap found{name, nullptr, MapFinding::kFailed, ""};
  {
    const std::lock_guard lock(mutex_);
    const auto it = entries_.find(name);
    if (it != entries_.end() && it->second.opening_bytes > memory_->limit()) {
      found.finding = MapFinding::kTooLarge;
      found.code = ErrorCode::kNoRoom;
      found.error = "takes " + Megabytes(it->second.opening_bytes) + " of memory to open, and " +
                    Megabytes(memory_->limit()) + " are allowed";
      return found;
    }
  }
  try {
    found.map = Find(name, deadline, yields);
    if (!found.map) return std::nullopt;
    found.finding = MapFinding::kFound;
  } catch (const MapLate& late) {
    found.finding = MapFinding::kLate;
    found.error = late.what();
  } catch (const MapError& error) {
    found.error = error.what();
    found.code = error.code();
  } catch (const std::bad_alloc&) {
    found.error = "out of memory";
    found.code = ErrorCode::kOutOfMemory;
  }
  return found;
}

std::vector<FoundMap> RegistryMaps::FindLot(std::span<const std::string> names,
                                            const Deadline& deadline) {
  size_t count = 0;
  {
    // What fits together is opened at the same time.
    const std::lock_guard lock(mutex_);
    int64_t bytes = 0;
    for (const std::string& name : names) {
      const auto it = entries_.find(name);
      const bool opens = it != entries_.end() && it->second.opening_bytes <= memory_->limit();
      if (opens && count > 0 && bytes + it->second.opening_bytes > memory_->limit()) break;
      ++count;
      if (!opens) continue;
      Entry& entry = it->second;
      bytes += entry.opening_bytes;
      entry.last_use = ++uses_;
      if (!entry.open && !entry.MustWait() && !ended_waits_) QueueOpening(name, entry);
    }
  }
  const Clock::time_point until = WaitUntil(deadline);
  std::vector<FoundMap> found;
  for (const std::string& name : names.first(count)) {
    const bool has_any =
        std::ranges::any_of(found, [](const FoundMap& one) { return one.map != nullptr; });
    std::optional<FoundMap> one = TryToFind(name, until, has_any);
    if (!one) break;
    found.push_back(std::move(*one));
  }
  return found;
}

}  // namespace waystone
