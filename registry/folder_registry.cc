// SPDX-License-Identifier: Apache-2.0
#include "registry/folder_registry.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <system_error>
#include <thread>
#include <utility>

#include "api/json.h"
#include "api/query_request_json.h"
#include "core/base/clock.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "schema/file/file_replacer.h"
#include "schema/file/folder_entries.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFormatName = "waystone-registry";
constexpr const char* kExtension = ".json";
// Whoever holds the lock writes two small files.
constexpr double kLockPatienceS = 30;
constexpr std::chrono::milliseconds kLockPause{10};
// A manifest has some kilobytes.
constexpr size_t kMaxFileBytes = 16'000'000;

[[noreturn]] void Fail(const fs::path& path, const std::string& cause, const std::string& remedy,
                       ErrorCode code = ErrorCode::kFileUnreadable) {
  throw MapError(code, path.string() + ": " + cause + "; " + remedy);
}

// The lock of a registry, while it exists.
class RegistryLock {
 public:
  explicit RegistryLock(const fs::path& folder) {
    const fs::path path = folder / "lock";
    file_ = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (file_ < 0) Fail(path, std::strerror(errno), "check the rights of the registry's folder");
    const Clock::time_point start = Clock::now();
    while (flock(file_, LOCK_EX | LOCK_NB) != 0) {
      const int cause = errno;
      const bool held = cause == EWOULDBLOCK || cause == EINTR;
      if (held && SecondsSince(start) < kLockPatienceS) {
        std::this_thread::sleep_for(kLockPause);
        continue;
      }
      close(file_);
      Fail(path,
           held ? "another program has been changing the registry for 30 s" : std::strerror(cause),
           "try again later", ErrorCode::kRegistryUnavailable);
    }
  }
  ~RegistryLock() { close(file_); }
  RegistryLock(const RegistryLock&) = delete;
  RegistryLock& operator=(const RegistryLock&) = delete;

 private:
  int file_ = -1;
};

std::string ReadText(const fs::path& path) {
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  std::string text(std::istreambuf_iterator<char>(in), {});
  if (!in.is_open() || in.bad()) {
    Fail(path, errno == 0 ? "cannot be read" : std::strerror(errno),
         "check that the registry's folder is there and may be read");
  }
  if (text.size() > kMaxFileBytes) Fail(path, "is too large", "restore it from a backup");
  return text;
}

void WriteText(const fs::path& path, const std::string& text, bool overwrite) {
  FileReplacer file(path, overwrite);
  std::ofstream out(file.temporary(), std::ios::binary);
  out << text << '\n';
  out.close();
  if (!out) throw UnwritableError(path, std::strerror(errno), static_cast<int64_t>(text.size()));
  file.Commit();
}

// Distinguishes one content of a file or folder from another without reading it.
struct EntryStamp {
  int64_t changed_ns = -1;  // -1 for nothing there
  uint64_t inode = 0;
  int64_t bytes = 0;
  bool operator==(const EntryStamp&) const = default;
};

EntryStamp StampOf(const fs::path& path) {
  struct stat status = {};
  if (stat(path.c_str(), &status) != 0) return {};
  constexpr int64_t kNsPerS = 1'000'000'000;
  return {status.st_mtim.tv_sec * kNsPerS + status.st_mtim.tv_nsec, status.st_ino, status.st_size};
}

// Names of the files of a folder that are ours, but for those that are still being written.
std::vector<std::string> ManifestNames(const fs::path& folder) {
  std::vector<std::string> names;
  try {
    for (const std::string& entry : FolderEntries(folder)) {
      if (entry.starts_with('.') || !entry.ends_with(kExtension)) continue;
      names.push_back(entry.substr(0, entry.size() - std::strlen(kExtension)));
    }
  } catch (const fs::filesystem_error& error) {
    Fail(folder, error.code().message(), "check that the registry's folder is there");
  }
  std::ranges::sort(names);
  return names;
}

class FolderRegistry : public Registry {
 public:
  explicit FolderRegistry(fs::path folder) : folder_(std::move(folder)) {
    const Json head = ReadHead();
    id_ = head.at("id").get<std::string>();
    store_ = head.at("store").get<std::string>();
    if (store_.empty()) store_ = (folder_ / "files").string();
  }

  const std::string& id() const override { return id_; }
  const std::string& store() const override { return store_; }

  MapVersion Publish(const MapVersion& version) override {
    CheckMapName(version.name);
    const RegistryLock lock(folder_);
    const std::optional<MapState> state = SoundState(version.name);
    if (state && IsPublished(*state, version)) return state->version;
    MapVersion next = version;
    const std::vector<int> numbers = Numbers(version.name);
    next.number = numbers.empty() ? 1 : numbers.back() + 1;
    std::error_code error;
    fs::create_directories(VersionsOf(next.name), error);
    if (error) throw UnwritableError(VersionsOf(next.name), error.message(), 0);
    WriteText(VersionPath(next.name, next.number), ManifestOf(next), false);
    WriteState({next, false});
    return next;
  }

  std::vector<MapVersion> Versions(const std::string& name) override {
    CheckMapName(name);
    std::vector<MapVersion> versions;
    for (const int number : Numbers(name)) versions.push_back(ReadVersion(name, number));
    if (versions.empty()) throw NoMapError(name);
    return versions;
  }

  MapVersion Rollback(const std::string& name, std::optional<int> number) override {
    CheckMapName(name);
    const RegistryLock lock(folder_);
    if (!HasState(name)) throw NoMapError(name);
    MapState state;
    state.version.name = name;
    if (!number) state = ReadState(name);  // a given version replaces a damaged state, too
    const MapVersion version = ReadVersion(name, RollbackNumber(state, Numbers(name), number));
    WriteState({version, false});
    return version;
  }

  void Retire(const std::string& name) override {
    CheckMapName(name);
    const RegistryLock lock(folder_);
    if (!HasState(name)) throw NoMapError(name);
    WriteState({ReadState(name).version, true});
  }

  RegistryNews Refresh() override {
    // A missing folder, or another registry in its place, isn't an empty list of maps.
    if (ReadHead().at("id") != id_) {
      Fail(folder_, "is a different registry now", "restart the server");
    }
    // The stamp of a folder may be as coarse as a tick of the clock: what changed just after the
    // last look is found by looking once more.
    const EntryStamp stamp = StampOf(folder_ / "current");
    if (stamp == stamp_ && settled_) return LookAtUnread();
    settled_ = stamp == stamp_;
    stamp_ = stamp;
    RegistryNews news;
    news.complete = known_.empty();
    const std::vector<std::string> names = ManifestNames(folder_ / "current");
    std::erase_if(unread_, [&](const auto& one) {
      return std::ranges::find(names, one.first) == names.end();
    });
    for (const std::string& name : names) Look(name, news);
    return news;
  }

 private:
  fs::path StatePath(const std::string& name) const {
    return folder_ / "current" / (name + kExtension);
  }
  fs::path VersionsOf(const std::string& name) const { return folder_ / "versions" / name; }
  fs::path VersionPath(const std::string& name, int number) const {
    return VersionsOf(name) / (std::to_string(number) + kExtension);
  }

  Json ReadHead() const {
    const fs::path path = folder_ / "registry.json";
    const std::string text = ReadText(path);
    const Json head = Json::parse(text, nullptr, false);
    const bool ours = head.is_object() && head.value("format", Json()) == kFormatName &&
                      head.contains("version") && head["version"].is_number_integer();
    if (!ours) Fail(path, "is not the head of a registry", "check the path");
    CheckRegistryFormat(folder_.string(), head["version"].get<int>());
    if (head.value("id", Json()).is_string() && head.value("store", Json()).is_string())
      return head;
    Fail(path, "is not the head of a registry", "check the path");
  }

  // Numbers of the versions of a name, ascending.
  std::vector<int> Numbers(const std::string& name) const {
    std::vector<int> numbers;
    std::error_code ignored;
    if (!fs::exists(VersionsOf(name), ignored)) return numbers;
    for (const std::string& text : ManifestNames(VersionsOf(name))) {
      const std::optional<int64_t> number = ToInteger(text);
      const bool is_version = number && *number > 0 && std::in_range<int>(*number);
      if (is_version) numbers.push_back(static_cast<int>(*number));
    }
    std::ranges::sort(numbers);
    return numbers;
  }

  MapVersion ReadVersion(const std::string& name, int number) const {
    const fs::path path = VersionPath(name, number);
    const MapVersion version = ReadManifest(ReadText(path), path.string());
    if (version.name != name) Fail(path, "is of another map", "restore it from a backup");
    return version;
  }

  bool HasState(const std::string& name) const {
    std::error_code ignored;
    return fs::exists(StatePath(name), ignored);
  }

  static MapState ParseState(const std::string& text, const fs::path& path,
                             const std::string& name) {
    constexpr const char* kRemedy =
        "publish the map again, or make one of its versions current (waystone rollback --version)";
    const Json json = Json::parse(text, nullptr, false);
    const bool sound =
        json.is_object() && json.contains("version") && json.value("retired", Json()).is_boolean();
    if (!sound) Fail(path, "is not the state of a map", kRemedy);
    MapState state{{}, json["retired"].get<bool>()};
    try {
      state.version = ReadManifest(Dump(json["version"]), path.string());
    } catch (const MapError&) {
      Fail(path, "is not the state of a map", kRemedy);
    }
    if (state.version.name != name) Fail(path, "is of another map", kRemedy);
    return state;
  }

  MapState ReadState(const std::string& name) const {
    return ParseState(ReadText(StatePath(name)), StatePath(name), name);
  }

  // Nothing for a damaged state, which the next one replaces. Throws for one that can't be read.
  std::optional<MapState> SoundState(const std::string& name) const {
    if (!HasState(name)) return std::nullopt;
    const std::string text = ReadText(StatePath(name));
    try {
      return ParseState(text, StatePath(name), name);
    } catch (const MapError&) {
      return std::nullopt;
    }
  }

  void WriteState(const MapState& state) const {
    const Json json = {{"retired", state.retired},
                       {"version", Json::parse(ManifestOf(state.version))}};
    WriteText(StatePath(state.version.name), Dump(json), true);
  }

  // A stamp says nothing about permissions, or about a network that failed.
  RegistryNews LookAtUnread() {
    RegistryNews news;
    const std::map<std::string, std::string> unread = unread_;  // Look() changes them
    for (const auto& [name, why] : unread) Look(name, news);
    return news;
  }

  // Reads the state of one map if it has changed, or couldn't be read before.
  void Look(const std::string& name, RegistryNews& news) {
    const EntryStamp stamp = StampOf(StatePath(name));
    const auto [known, is_new] = known_.try_emplace(name);
    const auto unread = unread_.find(name);
    if (!is_new && known->second == stamp && unread == unread_.end()) return;
    known->second = stamp;
    try {
      news.changed.push_back(ReadState(name));
      if (unread != unread_.end()) unread_.erase(unread);
    } catch (const MapError& error) {
      std::string& told = unread_[name];
      if (told != error.what()) news.problems.push_back({name, error.what()});
      told = error.what();
    }
  }

  fs::path folder_;
  std::string id_;
  std::string store_;
  EntryStamp stamp_;      // of the folder of states, at the last look
  bool settled_ = false;  // the last look was the second one with this stamp
  std::map<std::string, EntryStamp> known_;
  std::map<std::string, std::string> unread_;  // maps whose state couldn't be read: why
};

void RefuseOtherFiles(const fs::path& folder) {
  for (const std::string& name : FolderEntries(folder)) {
    if (name == "lock" || name == "current" || name.starts_with('.')) continue;
    Fail(folder, "has no registry.json, but other files",
         "give an empty folder, or one that is a registry");
  }
}

bool IsRegistry(const fs::path& folder) {
  std::error_code ignored;
  return fs::exists(folder / "registry.json", ignored);
}

void CreateRegistry(const fs::path& folder, const NewRegistry& registry) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw UnwritableError(folder, error.message(), 0);
  try {
    RefuseOtherFiles(folder);  // before the lock, which would be one more
  } catch (const MapError&) {
    if (IsRegistry(folder)) return;  // another program was faster
    throw;
  }
  const RegistryLock lock(folder);
  if (IsRegistry(folder)) return;
  RefuseOtherFiles(folder);
  fs::create_directories(folder / "current", error);
  if (error) throw UnwritableError(folder, error.message(), 0);
  const Json head = {{"format", kFormatName},
                     {"version", kRegistryFormat},
                     {"id", NewRegistryId()},
                     {"store", registry.store}};
  WriteText(folder / "registry.json", Dump(head), false);
}

}  // namespace

std::unique_ptr<Registry> OpenFolderRegistry(const fs::path& folder,
                                             const std::optional<NewRegistry>& create) {
  if (create && !IsRegistry(folder)) CreateRegistry(folder, *create);
  return std::make_unique<FolderRegistry>(folder);
}

}  // namespace waystone
