// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>

#include "schema/map_data.h"

namespace waystone {

// Fills an empty file with a map. The same data give the same bytes, whatever the file is called.
// The map must have no problem (FindMapProblems). Throws SQLite::Exception, for a
// full disk with the system's word for it; the file is worth nothing then.
void WriteDatabase(const MapData& map, const std::filesystem::path& path);

// Bytes that the map's file will have, to a few per cent; for messages.
int64_t EstimateBytes(const MapData& map);

}  // namespace waystone
