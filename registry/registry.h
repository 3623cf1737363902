// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "registry/map_version.h"

namespace waystone {

// A name in a registry and the version that it stands for.
struct MapState {
  MapVersion version;    // the current one; of a retired map the one that was current
  bool retired = false;  // the name is no longer served

  bool operator==(const MapState&) const = default;
};

// What has changed in a registry since it was last asked.
struct RegistryNews {
  struct Problem {
    std::string name;
    std::string message;  // one line
  };
  std::vector<MapState> changed;  // each name once
  std::vector<Problem> problems;  // maps that can't be read; they stay as they were
  bool complete = false;          // there are no other names
};

// The names of published maps, their versions, and which of them is current. A folder or a
// PostgreSQL database holds it; the map files are in a store (registry/store.h). Versions are only
// ever added, with the next number of their name. Several programs may change a registry at the
// same time: changes are made one after the other. Nothing depends on clocks. Not thread-safe. All
// functions throw MapError with the cause: kRegistryUnavailable for a registry that can't be
// reached now, kFileUnreadable for one that can't be used.
class Registry {
 public:
  virtual ~Registry() = default;

  // Made with the registry and never changed: distinguishes it from others.
  virtual const std::string& id() const = 0;
  // Where the map files are, for OpenStore.
  virtual const std::string& store() const = 0;

  // Adds a version with the next number of its name and makes it current, unless the current one is
  // the same already (IsPublished). The store must have the file. Returns the version with its
  // number.
  virtual MapVersion Publish(const MapVersion& version) = 0;
  // Versions of a name, ascending. Throws MapError(kNotFound) for a name that was never published.
  virtual std::vector<MapVersion> Versions(const std::string& name) = 0;
  // Makes an earlier version current: `number`, or else the one before the current one, or of a
  // retired map the one that was current. Throws MapError(kNotFound) where there is none.
  virtual MapVersion Rollback(const std::string& name, std::optional<int> number) = 0;
  // Retires a name; its versions stay. Throws MapError(kNotFound) for an unknown one.
  virtual void Retire(const std::string& name) = 0;

  // What has changed since the last call; on the first call everything. Cheap when nothing has.
  virtual RegistryNews Refresh() = 0;
  // A descriptor that becomes readable when Refresh() should be called at once; -1 for none.
  virtual int news_fd() const { return -1; }
};

// The settings of a new registry.
struct NewRegistry {
  std::string store;  // for OpenStore; empty: the registry's own folder
};

// Whether `url` is the address of a PostgreSQL database, which has jobs, too. Pure; thread-safe.
bool IsPostgres(const std::string& url);

// Opens a registry: "postgresql://..." or a folder. With `create`, a missing one is made.
// A request to stop ends the wait for a database that doesn't answer. Throws MapError: as its
// functions do, kFileUnreadable for a format of another version, and kFileUnwritable.
std::unique_ptr<Registry> OpenRegistry(const std::string& url,
                                       const std::optional<NewRegistry>& create = std::nullopt,
                                       std::stop_token stop = {});

// The version of the formats of folders and databases; others are refused.
inline constexpr int kRegistryFormat = 1;

// ---- for the registries

// A new id: 32 random hexadecimal digits.
std::string NewRegistryId();
// Throws MapError(kFileUnreadable) unless the format is this program's.
void CheckRegistryFormat(const std::string& url, int format);
// The errors (kNotFound) to throw for a name or version that a registry doesn't have.
MapError NoMapError(const std::string& name);
MapError NoVersionError(const std::string& name, std::optional<int> number);
// Whether publishing `next` changes nothing.
bool IsPublished(const MapState& state, const MapVersion& next);
// The version that Rollback makes current. `versions` are the name's, ascending. Throws as Rollback
// does.
int RollbackNumber(const MapState& state, const std::vector<int>& versions,
                   std::optional<int> number);

}  // namespace waystone
