// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "api/json.h"
#include "localizer/index/map_index.h"

namespace waystone {

// A map's entry of the coarse index, as it is in the store.
struct CoarseFile {
  std::string sha256;
  int64_t bytes = 0;

  bool operator==(const CoarseFile&) const = default;
};

// A published version of a map. A published version never changes.
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
  //   tags          given at publication, each once, sorted
  //   coarse        {sha256, bytes} of its entry of the coarse index; missing where it has none,
  //                 and in versions published before there was such an index
  //   published_at  UTC by the publisher's clock, for people: nothing depends on it
  //   publisher     host name
  //   summary       what GET /v1/maps lists of the map (MapJson)
  std::string details;

  bool operator==(const MapVersion&) const = default;
};

// "lab, version 3".
std::string Describe(const MapVersion& version);

// A version, yet to be published, of a map file of `bytes` that was read into `index`. Throws
// MapError(kUsage) for what CheckMapName or CheckTags refuses. Thread-safe, as all functions here.
MapVersion MakeVersion(const std::string& name, const MapIndex& index, int64_t bytes,
                       std::vector<std::string> tags,
                       const std::optional<CoarseFile>& coarse = std::nullopt);

// Throws MapError(kUsage) unless `name` can be the name of a registered map: 1 to 100 bytes of
// UTF-8 without control characters and slashes, not starting with a dot.
void CheckMapName(const std::string& name);
// The same for tags: each must be 1 to 100 bytes of UTF-8 without control characters.
void CheckTags(const std::vector<std::string>& tags);
// Each tag once, sorted: neither the order nor repetitions make a difference.
std::vector<std::string> SortedTags(std::vector<std::string> tags);

// The name of this machine, for people; "unknown" where the system doesn't tell it.
std::string HostName();

// A version as one JSON object, and back. Reading throws MapError(kFileUnreadable), with a message
// that begins with `where`, for anything else.
std::string ManifestOf(const MapVersion& version);
MapVersion ReadManifest(const std::string& text, const std::string& where);

// What GET /v1/maps lists of a version.
Json SummaryOf(const MapVersion& version);

// What decides whether a query of all maps concerns this one, and how it is found.
struct MapTraits {
  std::vector<std::string> tags;
  std::string frame;        // of the bounds; empty for a map without positions
  std::vector<double> min;  // the bounds' corners, in the frame's unit; as many numbers each
  std::vector<double> max;
  std::optional<CoarseFile> coarse;

  bool operator==(const MapTraits&) const = default;
};
// Leaves out what isn't as expected: other programs wrote the details.
MapTraits TraitsOf(const MapVersion& version);

// Whether the map has that layer: "planes", "appearance", "orientation" or "poses".
bool HasLayer(const MapVersion& version, const std::string& layer);

}  // namespace waystone
