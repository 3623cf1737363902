// SPDX-License-Identifier: Apache-2.0
// What RegistryMaps knows of its registry: from the registry, and from the cache when that is gone.
#include <poll.h>
#include <sys/eventfd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <new>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <utility>

#include "api/query_request_json.h"
#include "core/base/error.h"
#include "schema/file/file_replacer.h"
#include "schema/file/sha256.h"
#include "server/service/map_bytes.h"
#include "server/service/registry_maps.h"

namespace waystone {
namespace {

constexpr double kWriteKnownS = 5;  // between writes of what is known
constexpr double kMaxPauseS = 1;    // before what has failed is tried again
constexpr int kKnownFormat = 1;

std::string HashOf(const std::string& text) {
  return Sha256({reinterpret_cast<const unsigned char*>(text.data()), text.size()});
}

std::filesystem::path KnownPath(const std::filesystem::path& cache) {
  return cache / "known.jsonl";
}

}  // namespace

// The head, then a line for each map. The registry's address isn't in it: it may have a password.
bool RegistryMaps::ReadKnown() {
  std::ifstream in(KnownPath(options_.cache));
  std::string line;
  if (!std::getline(in, line)) return false;
  try {
    const Json head = ParseJson(line);
    const bool ours =
        head.at("format") == kKnownFormat && head.at("registry") == HashOf(options_.registry);
    if (!ours) return false;
    registry_id_ = head.at("id").get<std::string>();
    registry_store_ = head.at("store").get<std::string>();
    while (std::getline(in, line)) {
      const Json json = ParseJson(line, kAnswerBounds);
      Entry entry;
      SetCurrent(ReadManifest(Dump(json.at("current")), KnownPath(options_.cache).string()), entry);
      if (!json.at("served").is_null()) {
        entry.served = ReadManifest(Dump(json["served"]), KnownPath(options_.cache).string());
      }
      const std::string name = entry.current.name;
      entries_.insert_or_assign(name, std::move(entry));
    }
    return true;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    log_(KnownPath(options_.cache).string() + " is damaged, and not used: " + error.what());
  }
  for (const auto& [name, entry] : entries_) coarse_.Forget(name);
  entries_.clear();
  registry_id_.clear();
  return false;
}

// Empty where nothing has changed since the last time, unless the file alone is missing: in a cache
// that was removed and made again.
std::string RegistryMaps::TakeKnown() {
  const std::lock_guard lock(mutex_);
  std::error_code ignored;
  const bool is_missing = std::filesystem::is_directory(options_.cache, ignored) &&
                          !std::filesystem::exists(KnownPath(options_.cache), ignored);
  if (!known_changed_ && !is_missing) return {};
  std::string text = Dump({{"format", kKnownFormat},
                           {"registry", HashOf(options_.registry)},
                           {"id", registry_id_},
                           {"store", registry_store_}}) +
                     "\n";
  for (const auto& [name, entry] : entries_) {
    text += "{\"current\":" + ManifestOf(entry.current) +
            ",\"served\":" + (entry.served ? ManifestOf(*entry.served) : "null") + "}\n";
  }
  known_changed_ = false;
  return text;
}

void RegistryMaps::WriteKnown() {
  const std::string text = TakeKnown();
  if (text.empty()) return;
  written_ = Clock::now();
  try {
    cache_.Restore();
    FileReplacer file(KnownPath(options_.cache), true);
    std::ofstream out(file.temporary(), std::ios::binary);
    out << text;
    out.close();
    if (!out) throw UnwritableError(KnownPath(options_.cache), std::strerror(errno), 0);
    file.Commit();
    unwritten_.clear();
  } catch (const std::exception& error) {
    {
      const std::lock_guard lock(mutex_);
      known_changed_ = true;  // tried again
    }
    const std::string why = error.what();
    if (std::exchange(unwritten_, why) != why) log_(why);
  }
}

void RegistryMaps::CheckId(const Registry& registry) {
  const std::lock_guard lock(mutex_);
  if (registry_id_ == registry.id()) return;
  if (serving_) {
    throw MapError(ErrorCode::kFileUnreadable,
                   "the registry is another one than before; start the server anew");
  }
  for (const auto& [name, entry] : entries_) coarse_.Forget(name);
  entries_.clear();  // of the cache
  registry_id_ = registry.id();
}

void RegistryMaps::Look() {
  try {
    if (!registry_) {
      registry_ = OpenRegistry(options_.registry, std::nullopt, stop_.get_token());
      CheckId(*registry_);
    }
    Apply(registry_->Refresh());
  } catch (...) {
    registry_.reset();
    const std::lock_guard lock(mutex_);
    connected_ = false;
    throw;
  }
}

void RegistryMaps::Apply(const RegistryNews& news) {
  const std::lock_guard lock(mutex_);
  if (options_.store.empty() && registry_store_ != registry_->store()) {
    store_ = OpenStore(registry_->store());
    registry_store_ = registry_->store();
    known_changed_ = true;
  }
  connected_ = true;
  answered_ = Clock::now();
  std::set<std::string> gone;
  if (news.complete) {
    for (const auto& [name, entry] : entries_) gone.insert(name);
    known_changed_ = true;
  }
  for (const RegistryNews::Problem& problem : news.problems) {
    gone.erase(problem.name);
    log_("map " + problem.name + ": " + problem.message);
  }
  for (const MapState& state : news.changed) {
    if (!state.retired) gone.erase(state.version.name);
    if (!state.retired) ApplyState(state);
    if (state.retired) Forget(state.version.name);
  }
  for (const std::string& name : gone) Forget(name);
}

void RegistryMaps::ApplyState(const MapState& state) {
  Entry& entry = entries_[state.version.name];
  if (entry.current == state.version) return;
  SetCurrent(state.version, entry);
  entry.failures = 0;
  known_changed_ = true;
  if (entry.open && entry.open->version() != entry.current.sha256) {
    QueueOpening(state.version.name, entry);
  }
}

void RegistryMaps::SetCurrent(const MapVersion& version, Entry& entry) {
  entry.current = version;
  entry.traits = TraitsOf(version);
  entry.open_bytes = OpenBytes(version);
  entry.opening_bytes = OpeningBytes(version);
  coarse_.Set(version.name, version.sha256, entry.traits.coarse);
}

void RegistryMaps::Forget(const std::string& name) {
  coarse_.Forget(name);
  const auto it = entries_.find(name);
  if (it == entries_.end()) return;
  if (it->second.open) log_("map " + name + ": retired; no longer served");
  open_bytes_ -= it->second.bytes;
  if (it->second.opening) it->second.opening->done = true;
  entries_.erase(it);
  known_changed_ = true;
  changed_.notify_all();
}

// Open maps of which another version is current, after failures too.
void RegistryMaps::QueueUpdates() {
  const std::lock_guard lock(mutex_);
  for (auto& [name, entry] : entries_) {
    const bool behind = entry.open && entry.open->version() != entry.current.sha256;
    if (behind && !entry.opening && Clock::now() >= entry.retry_at) QueueOpening(name, entry);
  }
}

void RegistryMaps::KeepLooking() {
  Clock::time_point looked = Clock::now();
  while (true) {
    std::array<pollfd, 2> watched{{{wake_.get(), POLLIN, 0}, {-1, POLLIN, 0}}};
    if (registry_) watched[1].fd = registry_->news_fd();
    const int pause_ms = std::max(1, static_cast<int>(1e3 * std::min(options_.poll_s, kMaxPauseS)));
    const bool called = poll(watched.data(), watched.size(), pause_ms) > 0;
    eventfd_t ignored = 0;
    eventfd_read(wake_.get(), &ignored);
    {
      const std::lock_guard lock(mutex_);
      if (stopped_) break;
    }
    if (called || !registry_ || SecondsSince(looked) >= options_.poll_s) {
      LookAgain();
      looked = Clock::now();
    }
    try {
      QueueUpdates();
      if (SecondsSince(written_) >= kWriteKnownS) WriteKnown();
    } catch (const std::bad_alloc&) {  // the next look does what this one left
    }
  }
  try {
    WriteKnown();
  } catch (const std::bad_alloc&) {  // the next start asks the registry
  }
}

// Says when the registry goes and when it comes back.
void RegistryMaps::LookAgain() {
  const bool was_connected = registry_ != nullptr;
  try {
    Look();
    if (!was_connected) log_("the registry answers again");
  } catch (const std::bad_alloc&) {  // the next look does what this one left
  } catch (const std::exception& error) {
    if (was_connected) log_(std::string(error.what()) + "; serving what is known");
  }
}

void RegistryMaps::Refresh() {
  {
    const std::lock_guard lock(mutex_);
    for (auto& [name, entry] : entries_) {
      entry.failures = 0;
      entry.retry_at = {};
    }
  }
  coarse_.Retry();
  eventfd_write(wake_.get(), 1);
}

}  // namespace waystone
