// SPDX-License-Identifier: Apache-2.0
#include "server/service/registry_maps.h"

#include <sys/eventfd.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <new>
#include <utility>

#include "core/base/error.h"
#include "core/base/start_thread.h"
#include "core/base/text.h"
#include "schema/file/sha256.h"
#include "server/http/problem.h"
#include "server/service/map_bytes.h"

namespace waystone {
namespace {

constexpr int kOpeners = 4;  // maps fetched at once; one of them is read at a time
constexpr double kMemoryPatienceS = 20;
constexpr std::chrono::milliseconds kMemoryPause{50};
constexpr int kMaxRetryS = 60;
constexpr int64_t kCoarseShare = 4;  // of the memory of maps, for the coarse index
constexpr double kBytesPerMb = 1e6;

MapError NotServed(const std::string& name) {
  return {ErrorCode::kNotFound,
          "no map '" + Printable(name.substr(0, 80)) + "'; GET /v1/maps lists the maps"};
}
// What clients may read of an error: the cause names files and addresses of ours, but for want of
// room.
std::string ToldOf(const MapError& error) {
  if (const auto* full = dynamic_cast<const FullDiskError*>(&error)) return full->told();
  return error.code() == ErrorCode::kNoRoom ? error.what() : "";
}
[[noreturn]] void ThrowUnopened(const std::string& name, ErrorCode code, const std::string& told) {
  if (code == ErrorCode::kOutOfMemory) throw std::bad_alloc();
  const std::string cause =
      told.empty() ? std::string("it can't be opened now; the server's log says why") : told;
  throw MapError(code, "map '" + name + "': " + cause);
}
// Whether a file has the bytes of that hash; not one that was removed meanwhile.
bool IsIntact(const std::filesystem::path& file, const std::string& sha256) {
  try {
    return Sha256OfFile(file) == sha256;
  } catch (const MapError&) {
    return false;
  }
}
// A registry that can't be opened is refused before a cache is made for it.
const RegistryMapsOptions& Checked(const RegistryMapsOptions& options) {
  std::error_code ignored;
  if (!std::filesystem::exists(options.cache, ignored)) OpenRegistry(options.registry);
  return options;
}
// Whether no request has an open map, or its index. Requests only get them from the entry of which
// this is the pointer.
bool IsIdle(const MapSource::MapPtr& open) {
  return open.use_count() == 1 && open->shared_index().use_count() == 1;
}
MapError Ending() { return {ErrorCode::kNotReady, "the server is shutting down"}; }

// An open map with its share of the memory, which it gives back when it is gone.
struct HeldIndex {
  std::shared_ptr<MapMemory::Share> share;
  std::shared_ptr<const MapIndex> index;  // goes first
};

}  // namespace

std::string RegistryMaps::Megabytes(int64_t bytes) {
  return std::to_string(std::lround(static_cast<double>(bytes) / kBytesPerMb)) + " MB";
}

RegistryMaps::RegistryMaps(const RegistryMapsOptions& options, Log log)
    : options_(Checked(options)),
      log_(std::move(log)),
      memory_(std::make_shared<MapMemory>(options.memory_bytes)),
      cache_(options.cache, options.cache_bytes),
      coarse_(
          options.cache / "coarse", options.memory_bytes / kCoarseShare,
          [this] { return StoreNow(); }, log_),
      wake_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  const bool known = ReadKnown();
  try {
    Look();
  } catch (const MapError& error) {
    if (!known) throw;
    log_(std::string(error.what()) +
         "; serving what the cache knows of (maps: " + std::to_string(entries_.size()) + ")");
  }
  if (!options_.store.empty()) registry_store_ = options_.store;
  store_ = OpenStore(registry_store_);
  WriteKnown();
  serving_ = true;
  try {
    coarse_.Start();
    threads_.push_back(StartThread([this] { KeepLooking(); }));
    for (int i = 0; i < kOpeners; ++i) threads_.push_back(StartThread([this] { KeepOpening(); }));
  } catch (...) {
    Stop();
    throw;
  }
}

RegistryMaps::~RegistryMaps() { Stop(); }

void RegistryMaps::Stop() {
  cache_.Stop();
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    ended_waits_ = true;
  }
  stop_.request_stop();
  changed_.notify_all();
  eventfd_write(wake_.get(), 1);
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
  coarse_.Stop();
}

void RegistryMaps::EndWaits() {
  {
    const std::lock_guard lock(mutex_);
    ended_waits_ = true;
  }
  changed_.notify_all();
}

// ---- opening and closing

void RegistryMaps::QueueOpening(const std::string& name, Entry& entry) {
  if (entry.opening) return;
  auto opening = std::make_shared<Opening>();
  queue_.push_back(name);
  entry.opening = std::move(opening);  // which is in the queue: someone ends it
  changed_.notify_all();
}

void RegistryMaps::KeepOpening() {
  Lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return stopped_ || !queue_.empty(); });
    if (stopped_) return;
    const std::string name = std::move(queue_.front());
    queue_.pop_front();
    lock.unlock();
    try {
      OpenQueued(name);
    } catch (const std::bad_alloc&) {
      GiveUp(name);
    }
    lock.lock();
  }
}

// The current version, or else the one that was opened last. While the current one is not to be
// tried again yet, that one alone.
void RegistryMaps::OpenQueued(const std::string& name) {
  std::vector<MapVersion> wanted;
  std::optional<MapVersion> tried_current;
  {
    const std::lock_guard lock(mutex_);
    const auto it = entries_.find(name);
    if (it == entries_.end()) return;
    const Entry& entry = it->second;
    const bool has_other = !entry.open && entry.served && *entry.served != entry.current;
    if (!has_other || !entry.MustWait()) tried_current = entry.current;
    if (tried_current) wanted.push_back(*tried_current);
    if (has_other) wanted.push_back(*entry.served);
  }
  Opening failure;
  const auto fail = [&failure](ErrorCode code, const std::string& error,
                               const std::string& told = {}) {
    if (!failure.error.empty()) return;  // the first one counts
    failure.code = code;
    failure.error = error;
    failure.told = told;
  };
  Opened opened;
  MapVersion version;
  for (size_t i = 0; i < wanted.size() && !opened.map; ++i) {
    version = wanted[i];
    try {
      opened = OpenVersion(name, version);
    } catch (const std::bad_alloc&) {
      fail(ErrorCode::kOutOfMemory, "out of memory");
    } catch (const MapError& error) {
      fail(error.code(), error.what(), ToldOf(error));
    } catch (const std::exception& error) {
      fail(ErrorCode::kNotReady, error.what());
    }
  }
  Finish(name, version, std::move(opened), failure, tried_current);
}

RegistryMaps::Opened RegistryMaps::OpenVersion(const std::string& name, const MapVersion& version) {
  const std::shared_ptr<const Store> store = StoreNow();
  Opened opened;
  opened.file = cache_.Get(*store, version.sha256, version.bytes);
  const std::lock_guard one_at_a_time(opening_);
  const std::shared_ptr<MapMemory::Share> share = TakeMemory(version);
  std::shared_ptr<const MapIndex> index = ReadVersion(version, opened.file);
  opened.bytes = OpenBytes(version);
  share->ShrinkTo(opened.bytes);
  const auto held = std::make_shared<HeldIndex>(HeldIndex{share, std::move(index)});
  opened.map = std::make_shared<const ServedMap>(
      name, std::shared_ptr<const MapIndex>(held, held->index.get()));
  return opened;
}

std::shared_ptr<const MapIndex> RegistryMaps::ReadVersion(const MapVersion& version,
                                                          const MapCache::FilePtr& file) {
  std::string cause = "its bytes have changed";
  try {
    std::shared_ptr<const MapIndex> index = OpenForServing(file->path());
    if (index->map().info.version == version.sha256) return index;
  } catch (const MapError& error) {
    cause = error.what();
    if (IsIntact(file->path(), version.sha256)) throw;  // it was published so
  }
  cache_.Drop(version.sha256);
  throw MapError(ErrorCode::kNotReady,
                 "the file in the cache was damaged (" + cause + "); it is fetched again");
}

std::shared_ptr<MapMemory::Share> RegistryMaps::TakeMemory(const MapVersion& version) {
  const int64_t bytes = OpeningBytes(version);
  if (bytes > memory_->limit()) {
    throw MapError(ErrorCode::kNoRoom, "takes " + Megabytes(bytes) + " of memory to open, and " +
                                           Megabytes(memory_->limit()) +
                                           " are allowed; give the server more (--memory)");
  }
  const Clock::time_point start = Clock::now();
  while (SecondsSince(start) < kMemoryPatienceS) {
    MakeRoom(bytes);
    std::shared_ptr<MapMemory::Share> share = memory_->Take(bytes, kMemoryPause);
    const std::lock_guard lock(mutex_);
    wants_room_ = !share;
    if (share) return share;
    changed_.notify_all();
  }
  {
    const std::lock_guard lock(mutex_);
    wants_room_ = false;
  }
  throw MapError(ErrorCode::kNotReady,
                 "the memory for maps is taken by requests in progress; try again, or give the "
                 "server more (--memory)");
}

// Closes maps that no request uses, or else enough of the others, whose memory comes back with
// their requests.
void RegistryMaps::MakeRoom(int64_t bytes) {
  while (true) {
    MapPtr closed;  // goes outside the lock, with its memory where no request has it
    const std::lock_guard lock(mutex_);
    if (stopped_) throw Ending();
    if (memory_->used() + bytes <= memory_->limit()) return;
    closed = CloseOldest(true);
    if (!closed && open_bytes_ + bytes > memory_->limit()) closed = CloseOldest(false);
    if (!closed) return;
  }
}

MapSource::MapPtr RegistryMaps::CloseOldest(bool idle) {
  Entry* oldest = nullptr;
  for (auto& [name, entry] : entries_) {
    if (!entry.open || (idle && !IsIdle(entry.open))) continue;
    if (!oldest || entry.last_use < oldest->last_use) oldest = &entry;
  }
  if (!oldest) return nullptr;
  open_bytes_ -= std::exchange(oldest->bytes, 0);
  oldest->file = nullptr;
  ++counted_.closed;
  return std::exchange(oldest->open, nullptr);
}

void RegistryMaps::Finish(const std::string& name, const MapVersion& version, Opened opened,
                          const Opening& failure, const std::optional<MapVersion>& tried_current) {
  std::string said;
  {
    const std::lock_guard lock(mutex_);
    const auto it = entries_.find(name);
    if (it == entries_.end()) return;  // retired meanwhile
    Entry& entry = it->second;
    if (opened.map) {
      ++counted_.opened;
      if (entry.open) {
        ++counted_.swapped;
        said = "now serving version " + std::to_string(version.number);
      }
      open_bytes_ += opened.bytes - entry.bytes;
      std::swap(entry.open, opened.map);  // the old one goes outside the lock
      std::swap(entry.file, opened.file);
      entry.bytes = opened.bytes;
      known_changed_ |= entry.served != version;
      entry.served = version;
    }
    // Another version that was published meanwhile has had no try.
    if (tried_current == entry.current) Count(failure, entry, said);
    if (const std::shared_ptr<Opening> opening = std::exchange(entry.opening, nullptr)) {
      opening->map = entry.open;
      opening->error = failure.error;
      opening->told = failure.told;
      opening->code = failure.code;
      opening->done = true;
    }
  }
  changed_.notify_all();
  if (!said.empty()) log_("map " + name + ": " + said);
}

// Where there is no memory to say what became of it: takes none itself.
void RegistryMaps::GiveUp(const std::string& name) {
  {
    const std::lock_guard lock(mutex_);
    const auto it = entries_.find(name);
    if (it == entries_.end() || !it->second.opening) return;
    const std::shared_ptr<Opening> opening = std::exchange(it->second.opening, nullptr);
    opening->map = it->second.open;
    opening->error = "out of memory";
    opening->code = ErrorCode::kOutOfMemory;
    opening->done = true;
  }
  changed_.notify_all();
}

// What became of the current version.
void RegistryMaps::Count(const Opening& failure, Entry& entry, std::string& said) {
  if (failure.error.empty()) {
    entry.failures = 0;
    return;
  }
  ++counted_.refused;
  if (entry.failures == 0 || entry.error != failure.error) {
    said = "version " + std::to_string(entry.current.number) + ": " + failure.error + "; " +
           (entry.open ? "serving version " + std::to_string(entry.served->number) : "not served") +
           ", trying again";
  }
  ++entry.failures;
  entry.error = failure.error;
  entry.told = failure.told;
  entry.code = failure.code;
  const int retry_s = std::min(kMaxRetryS, 1 << std::min(entry.failures - 1, 10));
  entry.retry_at = Clock::now() + std::chrono::seconds(retry_s);
}

std::shared_ptr<const Store> RegistryMaps::StoreNow() const {
  const std::lock_guard lock(mutex_);
  return store_;
}

// ---- asking

const RegistryMaps::Entry& RegistryMaps::EntryOf(const std::string& name) const {
  const auto it = entries_.find(name);
  if (it == entries_.end()) throw NotServed(name);
  return it->second;
}

std::vector<std::string> RegistryMaps::Names() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> names;
  names.reserve(entries_.size());
  for (const auto& [name, entry] : entries_) names.push_back(name);
  return names;
}

void RegistryMaps::CheckName(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  EntryOf(name);
}

Clock::time_point RegistryMaps::WaitUntil(const Deadline& deadline) const {
  const Clock::time_point until =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(
                         std::chrono::duration<double>(options_.patience_s));
  return deadline ? std::min(until, *deadline) : until;
}

MapSource::MapPtr RegistryMaps::Find(const std::string& name, const Deadline& deadline) {
  return Find(name, deadline, false);
}

MapSource::MapPtr RegistryMaps::Find(const std::string& name, const Deadline& deadline,
                                     bool yields) {
  Lock lock(mutex_);
  const auto it = entries_.find(name);
  if (it == entries_.end()) throw NotServed(name);
  Entry& entry = it->second;
  entry.last_use = ++uses_;
  if (entry.open) return entry.open;
  if (ended_waits_) throw Ending();
  const bool has_other = entry.served && *entry.served != entry.current;
  if (entry.MustWait() && !has_other) ThrowUnopened(name, entry.code, entry.told);
  if (waiting_ >= kMaxWaiting) {
    throw BusyError("too many requests wait for maps to be opened; try again", 1);
  }
  QueueOpening(name, entry);
  const std::shared_ptr<Opening> opening = entry.opening;
  ++waiting_;
  changed_.wait_until(lock, WaitUntil(deadline),
                      [&] { return opening->done || ended_waits_ || (yields && wants_room_); });
  --waiting_;
  if (opening->map) return opening->map;
  if (!opening->error.empty()) ThrowUnopened(name, opening->code, opening->told);
  if (opening->done) throw NotServed(name);  // retired meanwhile
  if (ended_waits_) throw Ending();
  if (yields && wants_room_) return nullptr;
  throw MapLate("map '" + name + "' is being fetched and opened; try again in a moment");
}

Json RegistryMaps::Summary(const std::string& name) const {
  MapPtr open;
  {
    const std::lock_guard lock(mutex_);
    const Entry& entry = EntryOf(name);
    open = entry.open;
    if (!open) return SummaryOf(entry.current);
  }
  return open->summary();
}

Holdings RegistryMaps::holdings() const {
  const MapCache::Usage cache = cache_.usage();
  Holdings holdings;
  const std::lock_guard lock(mutex_);
  holdings.maps = entries_.size();
  RegistryHoldings& registry = holdings.registry.emplace(counted_);
  for (const auto& [name, entry] : entries_) holdings.open += entry.open ? 1 : 0;
  registry.connected = connected_;
  registry.silent_s = SecondsSince(answered_);
  registry.memory_bytes = memory_->used();
  registry.memory_limit = memory_->limit();
  registry.cached_files = cache.files;
  registry.cached_bytes = cache.bytes;
  registry.cache_limit = cache_.max_bytes();
  registry.fetched_files = cache.fetched_files;
  registry.fetched_bytes = cache.fetched_bytes;
  registry.failed_fetches = cache.failed_fetches;
  registry.coarse = coarse_.holdings();
  return holdings;
}

}  // namespace waystone
