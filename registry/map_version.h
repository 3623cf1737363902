// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "api/json.h"
#include "localizer/index/map_index.h"

namespace waystone {

// A map's entry of the coarse index, as the store has it.
struct CoarseFile {
  std::string sha256;
  int64_t bytes = 0;

  bool operator==(const CoarseFile&) const = default;
};

// A published version of a map. What is published once never changes.
struct MapVersion {
  std::string name;
  int number = 0;      // 1, 2, ... of this name; 0 before it is published
  std::string sha256;  // "sha256:<64 hex digits>" of the map file, as answers name the version
  int64_t bytes = 0;   // of the map file
  // One JSON object as text, because a server holds thousands of them:
  //   schema_version, feature_type, layers
  //   places        names of its named places, each once, sorted
  //   bounds        {frame, metres_per_unit (null if not known), min, max} of its keyframes in the
  //                 frame of the poses, or of its panoramas; null for maps without positions
  //   tags          given when it was published
  //   coarse        {sha256, bytes} of its entry of the coarse index; not there where it has none,
  //                 and in versions that were published before there was one
  //   published_at  UTC by the publisher's clock, for people: nothing is decided by it
  //   publisher     host name
  //   summary       what GET /v1/maps lists of the map (MapJson)
  std::string details;

  bool operator==(const MapVersion&) const = default;
};

// "lab, version 3".
std::string Describe(const MapVersion& version);

// A version to be published of a map file of `bytes` that was read into `index`. Thread-safe.
// Throws MapError(kUsage) for a name or tag that CheckMapName refuses.
MapVersion MakeVersion(const std::string& name, const MapIndex& index, int64_t bytes,
                       std::vector<std::string> tags,
                       const std::optional<CoarseFile>& coarse = std::nullopt);

// Throws MapError(kUsage) unless `name` can be the name of a registered map: 1 to 100 bytes of
// UTF-8 without control characters and slashes, and no dot first.
void CheckMapName(const std::string& name);
// The same for tags: 1 to 100 bytes of UTF-8 without control characters each.
void CheckTags(const std::vector<std::string>& tags);

// Of this machine, for people.
std::string HostName();

// A version as one JSON object and back. Reading throws MapError(kFileUnreadable), whose message
// begins with `where`, for what is no such object.
std::string ManifestOf(const MapVersion& version);
MapVersion ReadManifest(const std::string& text, const std::string& where);

// What GET /v1/maps lists of it.
Json SummaryOf(const MapVersion& version);

// What decides whether a query of all maps is for this one, and how it is found.
struct MapTraits {
  std::vector<std::string> tags;
  std::string frame;        // of the bounds; empty for a map without positions
  std::vector<double> min;  // as many numbers each
  std::vector<double> max;
  std::optional<CoarseFile> coarse;

  bool operator==(const MapTraits&) const = default;
};
// What doesn't fit isn't there: details are others' words.
MapTraits TraitsOf(const MapVersion& version);

// Whether the map has that layer: "planes", "appearance", "orientation" or "poses".
bool HasLayer(const MapVersion& version, const std::string& layer);

}  // namespace waystone
