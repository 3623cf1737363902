// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "schema/map_data.h"

namespace waystone {

struct MapShape {
  int sequences = 2;
  int keyframes = 6;
  int planes = 4;
  int max_features = 20;  // of a plane; each has 0 to this many
  int jpeg_bytes = 300;   // at most; some keyframes have none
  int max_landmarks = 8;  // of a keyframe; some have none
  FeatureType type = FeatureType::kSift;
};

// A sound map full of random values: odd names, absent optionals, gaps in the ids.
MapData MadeMap(uint64_t seed, const MapShape& shape = {});

// A folder of a test's own, removed with everything in it.
class TemporaryFolder {
 public:
  TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder();

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  // Names of what is in it, sorted.
  std::vector<std::string> Names() const;

 private:
  std::filesystem::path path_;
};

std::string ReadFile(const std::filesystem::path& path);
void WriteFile(const std::filesystem::path& path, const std::string& bytes);
// Changes a database as anybody with sqlite3 could.
void RunSql(const std::filesystem::path& path, const std::string& sql);

// The map without what only reading fills in.
MapData WithoutVersion(MapData map);

// The MapError that `run` throws; fails the test and gives kInternal when it throws none.
MapError ErrorOf(const std::function<void()>& run);

}  // namespace waystone
