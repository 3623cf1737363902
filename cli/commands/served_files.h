// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "server/service/map_catalog.h"

namespace waystone {

// The map files of a server: those given by name, and all *.db of the folders given. Reports what
// changed on disk, and reads it again. Not thread-safe; one thread looks after the files.
class ServedFiles {
 public:
  explicit ServedFiles(std::vector<std::filesystem::path> paths);

  // What became of one file, or what is wrong with several.
  struct Change {
    std::string name;     // of the map; empty for several
    std::string message;  // for people; with the cause when the map was refused
    bool good = true;     // the map was swapped, added or taken away
    bool retry = false;   // there was no memory for it: the next Refresh looks at it again
  };
  struct Opened {
    MapCatalog::Indices maps;
    std::vector<Change> refused;  // files of folders that can't be read; the others are served
  };
  // Reads all maps. Throws as ReadMap does for a file that was given by name, and where no file can
  // be read; MapError(kUsage) for two of one name and for none, and MapError(kFileUnreadable) for a
  // folder that can't be read.
  Opened OpenAll();

  // Looks for files that are new, gone or changed (with `all`, takes all as changed), and puts each
  // new map into the catalog once it is complete. A map that can't be read is refused: the previous
  // one stays in service, and the file is looked at again when it changes once more, or next time
  // if memory ran out. Of two files of one name the one that is served stays, and so do the maps of
  // a folder that can't be read; either is reported once. Throws std::bad_alloc; the next Refresh
  // does what this one left.
  std::vector<Change> Refresh(MapCatalog& catalog, bool all);

 private:
  // Distinguishes one content of a file from another without reading it.
  struct Stamp {
    std::filesystem::path path;
    std::filesystem::file_time_type time;
    uintmax_t size = 0;
    uint64_t inode = 0;
    bool operator==(const Stamp&) const = default;
  };
  struct Scanned {
    std::map<std::string, Stamp> found;  // by the maps' names
    std::vector<MapError> problems;
  };
  Scanned Scan() const;
  bool WasFolder(const std::filesystem::path& path) const;  // with maps that are served
  bool IsGiven(const std::filesystem::path& file) const;    // by its own name
  static Change Reload(MapCatalog& catalog, const std::string& name,
                       const std::filesystem::path& file);

  std::vector<std::filesystem::path> paths_;
  std::map<std::string, Stamp> known_;
  std::set<std::string> said_;  // problems that the last Refresh met
};

}  // namespace waystone
