// SPDX-License-Identifier: Apache-2.0
#include "server/service/coarse_maps.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <fstream>
#include <iterator>
#include <new>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/start_thread.h"
#include "schema/file/sha256.h"

namespace waystone {
namespace {

// Of files, beside those of maps: for ten thousand maps of a hundred places they are 0.8 of it.
constexpr int64_t kCacheBytes = 1'000'000'000;
// The memory that an entry takes, as a multiple of its file: its own and its share of the index,
// also while the next index is made.
constexpr int64_t kMemoryPerByte = 4;
constexpr int kMaxCoarseRetryS = 60;
// An index of ten thousand maps is made in less; entries that come meanwhile are in the next one.
constexpr double kRebuildS = 1;
constexpr std::chrono::milliseconds kPause{200};

}  // namespace

CoarseMaps::CoarseMaps(const std::filesystem::path& folder, int64_t max_bytes, StoreNow store,
                       Log log)
    : cache_(folder, kCacheBytes),
      max_bytes_(max_bytes),
      store_(std::move(store)),
      log_(std::move(log)) {}

CoarseMaps::~CoarseMaps() { Stop(); }

void CoarseMaps::Start() {
  thread_ = StartThread([this] { KeepFetching(); });
}

void CoarseMaps::Stop() {
  cache_.Stop();
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void CoarseMaps::Set(const std::string& name, const std::string& map_version,
                     const std::optional<CoarseFile>& file) {
  {
    const std::lock_guard lock(mutex_);
    Entry& entry = entries_[name];
    if (entry.map_version == map_version && entry.wanted == file) return;
    entry.map_version = map_version;
    entry.wanted = file;
    entry.failures = 0;
    entry.error.clear();
    entry.retry_at = {};
    if (!file) {
      held_bytes_ -= entry.held ? entry.held_file.bytes : 0;
      entry.held.reset();
    }
    index_is_old_ = true;
  }
  changed_.notify_all();
}

void CoarseMaps::Forget(const std::string& name) {
  {
    const std::lock_guard lock(mutex_);
    const auto it = entries_.find(name);
    if (it == entries_.end()) return;
    held_bytes_ -= it->second.held ? it->second.held_file.bytes : 0;
    entries_.erase(it);
    index_is_old_ = true;
  }
  changed_.notify_all();
}

void CoarseMaps::Retry() {
  {
    const std::lock_guard lock(mutex_);
    for (auto& [name, entry] : entries_) entry.retry_at = {};
  }
  changed_.notify_all();
}

std::shared_ptr<const CoarseIndex> CoarseMaps::index() const {
  const std::lock_guard lock(mutex_);
  return index_;
}

CoarseHoldings CoarseMaps::holdings() const {
  const std::shared_ptr<const CoarseIndex> held = index();
  CoarseHoldings holdings;
  holdings.maps = std::ssize(held->maps());
  holdings.places = held->places();
  holdings.bytes = held->bytes();
  const std::lock_guard lock(mutex_);
  holdings.refused = refused_;
  for (const auto& [name, entry] : entries_) {
    if (!entry.wanted) ++holdings.without;
    if (entry.wanted && !entry.IsHeld()) ++holdings.waiting;
    holdings.left_out += entry.left_out ? 1 : 0;
  }
  return holdings;
}

// ---- fetching

void CoarseMaps::KeepFetching() {
  while (!IsStopped()) {
    bool all = false;
    try {
      FetchWanted();
      all = true;
    } catch (const std::bad_alloc&) {  // the next round fetches what is left
    } catch (const std::exception& error) {
      log_("coarse index: " + std::string(error.what()) + "; trying again");
    }
    std::unique_lock lock(mutex_);
    if (!stopped_ && !(all && index_is_old_)) changed_.wait_for(lock, kPause);
  }
}

void CoarseMaps::FetchWanted() {
  Clock::time_point made = Clock::now();
  for (const Wanted& one : ListWanted()) {
    if (IsStopped()) return;
    Fetch(one);
    if (SecondsSince(made) < kRebuildS) continue;
    Rebuild();
    made = Clock::now();
  }
  Rebuild();
  TellWithout();
}

bool CoarseMaps::IsStopped() const {
  const std::lock_guard lock(mutex_);
  return stopped_;
}

// Entries that are missing, and may be tried now.
std::vector<CoarseMaps::Wanted> CoarseMaps::ListWanted() {
  const Clock::time_point now = Clock::now();
  const std::lock_guard lock(mutex_);
  std::vector<Wanted> wanted;
  int64_t bytes = held_bytes_;
  for (auto& [name, entry] : entries_) {
    entry.left_out = false;
    if (!entry.wanted || entry.IsHeld() || entry.retry_at > now) continue;
    const int64_t others = bytes - (entry.held ? entry.held_file.bytes : 0);
    entry.left_out = entry.wanted->bytes > max_bytes_ / kMemoryPerByte - others;
    if (entry.left_out) continue;
    bytes = others + entry.wanted->bytes;
    wanted.push_back({name, entry.map_version, *entry.wanted});
  }
  return wanted;
}

void CoarseMaps::Fetch(const Wanted& wanted) {
  try {
    Take(wanted, Read(wanted), "");
  } catch (const std::bad_alloc&) {
    Take(wanted, nullptr, "out of memory");
  } catch (const std::exception& error) {
    Take(wanted, nullptr, error.what());
  }
}

std::shared_ptr<const CoarseEntry> CoarseMaps::Read(const Wanted& wanted) {
  const std::string where = "the store's file " + StorePath(wanted.file.sha256);
  if (wanted.file.bytes > kMaxCoarseBytes) {
    throw MapError(ErrorCode::kFileUnreadable,
                   where + " is not an entry of the coarse index: it has " +
                       std::to_string(wanted.file.bytes) + " bytes; publish the map again");
  }
  const MapCache::FilePtr file = cache_.Get(*store_(), wanted.file.sha256, wanted.file.bytes);
  std::ifstream in(file->path(), std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(in), {});
  if (Sha256({reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()}) !=
      wanted.file.sha256) {
    cache_.Drop(wanted.file.sha256);
    throw MapError(ErrorCode::kNotReady, "the entry in the cache was damaged; it is fetched again");
  }
  auto entry = std::make_shared<const CoarseEntry>(DecodeCoarseEntry(bytes, where));
  if (entry->map_version == wanted.map_version) return entry;
  throw MapError(ErrorCode::kFileUnreadable,
                 where + " is the entry of another map; publish the map again");
}

void CoarseMaps::Take(const Wanted& wanted, std::shared_ptr<const CoarseEntry> taken,
                      const std::string& error) {
  bool is_new = false;
  {
    const std::lock_guard lock(mutex_);
    if (stopped_) return;
    const auto it = entries_.find(wanted.name);
    if (it == entries_.end()) return;
    Entry& entry = it->second;
    if (entry.wanted != wanted.file || entry.map_version != wanted.map_version) return;
    if (taken) {
      held_bytes_ += wanted.file.bytes - (entry.held ? entry.held_file.bytes : 0);
      entry.held = std::move(taken);
      entry.held_file = wanted.file;
      entry.failures = 0;
      index_is_old_ = true;
    } else {
      ++refused_;
      is_new = entry.error != error;
      entry.error = error;
      const int retry_s = std::min(kMaxCoarseRetryS, 1 << std::min(entry.failures++, 10));
      entry.retry_at = Clock::now() + std::chrono::seconds(retry_s);
    }
  }
  if (is_new) log_("map " + wanted.name + ": coarse index: " + error + "; trying again");
}

void CoarseMaps::Rebuild() {
  try {
    std::vector<CoarseIndex::Map> maps;
    {
      const std::lock_guard lock(mutex_);
      if (!std::exchange(index_is_old_, false)) return;
      for (const auto& [name, entry] : entries_) {
        if (entry.held) maps.push_back({name, entry.held});
      }
    }
    auto index = std::make_shared<const CoarseIndex>(std::move(maps));
    const std::lock_guard lock(mutex_);
    index_ = std::move(index);
  } catch (const std::bad_alloc&) {  // the previous index stays until the next change
    log_("coarse index: out of memory; keeping the previous one");
  }
}

// Reports once which maps searches can't find.
void CoarseMaps::TellWithout() {
  int64_t count = 0;
  std::string first;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [name, entry] : entries_) {
      if (entry.wanted) continue;
      if (count++ == 0) first = name;
    }
    if (std::exchange(told_without_, count) == count) return;
  }
  if (count == 0) return;
  log_("coarse index: maps without an entry: " + std::to_string(count) + " (" + first +
       (count > 1 ? ", ..." : "") +
       "); POST /v1/localize finds them after they are published again");
}

}  // namespace waystone
