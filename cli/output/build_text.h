// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "api/json.h"
#include "builder/build_map.h"
#include "schema/file/map_store.h"
#include "schema/map_data.h"

// What maps and builds look like to people, and to programs.
namespace waystone {

std::string BytesText(uint64_t bytes);       // "1.9 MB"
std::string CountsText(const MapData& map);  // "61 keyframes, 23 planes, 9 surfaces, ..."
std::string TablesText(const std::vector<TableSize>& sizes);  // a line per table, largest first
// A layer's sizes; null where there is none.
Json AppearanceJson(const MapData& map);
Json OrientationJson(const MapData& map);
Json TablesJson(const std::vector<TableSize>& sizes);

// A finished build: the map, what became of the frames, and seconds per stage.
struct BuildSummary {
  std::string path;
  std::string version;
  uint64_t bytes = 0;
  std::vector<TableSize> tables;
  const BuildResult* result = nullptr;
};

std::string SummaryText(const BuildSummary& summary);
Json SummaryJson(const BuildSummary& summary);

}  // namespace waystone
