// SPDX-License-Identifier: Apache-2.0
#include "cli/commands/served_files.h"

#include <sys/stat.h>

#include <algorithm>
#include <exception>
#include <new>
#include <utility>

#include "cli/files/map_file.h"
#include "core/base/error.h"
#include "schema/file/folder_entries.h"
#include "server/service/served_map.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExtension = ".db";

// Throws nothing for an entry that can't be looked at: opening it reports what is wrong.
// A folder that is gone, as while it isn't mounted, can't be read; it isn't a folder without maps.
std::vector<fs::path> ListFiles(const fs::path& path, bool was_folder) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path);  // throws where that can't be determined
  if (!fs::is_directory(status) && !(was_folder && !fs::exists(status))) return {path};
  std::vector<fs::path> files;
  for (const std::string& name : FolderEntries(path)) {
    const fs::path file = path / name;
    if (file.extension() == kExtension && !name.starts_with('.') &&
        !fs::is_directory(file, ignored)) {
      files.push_back(file);
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

// What becomes of a map whose new file was refused.
std::string Standing(const MapCatalog& catalog, const std::string& name) {
  return catalog.Now()->contains(name) ? "still serving the previous version" : "not served";
}

// Removes a folder's final slash, so that its files' parent_path() is the same.
fs::path WithoutSlash(const fs::path& path) {
  const fs::path normal = path.lexically_normal();
  return normal.has_filename() || !normal.has_relative_path() ? normal : normal.parent_path();
}

// No file has it, so a file with such a stamp counts as changed.
constexpr uint64_t kNoInode = 0;

}  // namespace

ServedFiles::ServedFiles(std::vector<fs::path> paths) : paths_(std::move(paths)) {
  std::ranges::transform(paths_, paths_.begin(), WithoutSlash);
}

ServedFiles::Scanned ServedFiles::Scan() const {
  Scanned scanned;
  std::map<std::string, Stamp>& found = scanned.found;
  for (const fs::path& path : paths_) {
    std::vector<fs::path> files;
    try {
      files = ListFiles(path, WasFolder(path));
    } catch (const fs::filesystem_error& error) {
      scanned.problems.emplace_back(ErrorCode::kFileUnreadable,
                                    "'" + path.string() +
                                        "' can't be read: " + error.code().message() +
                                        "; check that it exists, and its permissions");
      for (const auto& [name, stamp] : known_) {  // stay in service
        if (stamp.path.parent_path() == path) found.emplace(name, stamp);
      }
    }
    for (const fs::path& file : files) {
      struct stat status = {};
      std::error_code error;
      Stamp stamp{file, fs::last_write_time(file, error), 0, 0};
      if (stat(file.c_str(), &status) == 0) {
        stamp.size = static_cast<uintmax_t>(status.st_size);
        stamp.inode = status.st_ino;
      }
      const auto [it, is_new] = found.emplace(MapNameOf(file), stamp);
      if (is_new || it->second.path == file) continue;
      scanned.problems.emplace_back(ErrorCode::kUsage,
                                    it->second.path.string() + " and " + file.string() +
                                        " have the same name; maps are named after their files, "
                                        "so rename one");
      const auto known = known_.find(it->first);
      if (known != known_.end() && known->second.path == file) it->second = stamp;
    }
  }
  return scanned;
}

bool ServedFiles::WasFolder(const fs::path& path) const {
  return std::ranges::any_of(
      known_, [&](const auto& known) { return known.second.path.parent_path() == path; });
}

bool ServedFiles::IsGiven(const fs::path& file) const {
  return std::find(paths_.begin(), paths_.end(), file) != paths_.end();
}

ServedFiles::Opened ServedFiles::OpenAll() {
  Opened opened;
  Scanned scanned = Scan();
  if (!scanned.problems.empty()) throw MapError(scanned.problems.front());
  known_ = std::move(scanned.found);
  std::exception_ptr first;
  for (auto& [name, stamp] : known_) {
    try {
      opened.maps.emplace(name, OpenForServing(stamp.path));
    } catch (const std::bad_alloc&) {
      if (IsGiven(stamp.path)) throw;
      if (!first) first = std::current_exception();
      opened.refused.push_back({name, "out of memory; not served, trying again", false, true});
      stamp.inode = kNoInode;
    } catch (const std::exception& error) {
      if (IsGiven(stamp.path)) throw;
      if (!first) first = std::current_exception();
      opened.refused.push_back({name, std::string(error.what()) + "; not served", false});
    }
  }
  if (opened.maps.empty() && first) std::rethrow_exception(first);
  if (opened.maps.empty()) {
    throw MapError(ErrorCode::kUsage, "no map (*.db) in " + paths_.front().string() +
                                          "; create one with waystone build");
  }
  return opened;
}

ServedFiles::Change ServedFiles::Reload(MapCatalog& catalog, const std::string& name,
                                        const fs::path& file) {
  try {
    std::shared_ptr<const MapIndex> index = OpenForServing(file);
    const std::string version = index->map().info.version;
    catalog.Put(name, std::move(index));
    return {name, "now serving " + version, true};
  } catch (const std::bad_alloc&) {
    return {name, "not reloaded, out of memory; " + Standing(catalog, name) + ", trying again",
            false, true};
  } catch (const std::exception& error) {
    return {name, std::string(error.what()) + "; " + Standing(catalog, name), false};
  }
}

std::vector<ServedFiles::Change> ServedFiles::Refresh(MapCatalog& catalog, bool all) {
  std::vector<Change> changes;
  auto [found, problems] = Scan();
  std::set<std::string> said;
  for (const MapError& problem : problems) {
    said.insert(problem.what());
    if (!said_.contains(problem.what())) changes.push_back({"", problem.what(), false});
  }
  said_ = std::move(said);
  for (auto& [name, stamp] : found) {
    const auto before = known_.find(name);
    if (!all && before != known_.end() && before->second == stamp) continue;
    changes.push_back(Reload(catalog, name, stamp.path));
    if (changes.back().retry) stamp.inode = kNoInode;
  }
  // A file that was given by its name and is away for a moment is being replaced.
  for (const auto& [name, stamp] : known_) {
    if (found.contains(name) || IsGiven(stamp.path)) continue;
    catalog.Remove(name);
    changes.push_back({name, "file removed; no longer served", true});
  }
  known_ = std::move(found);
  return changes;
}

}  // namespace waystone
