// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>

#include "schema/map_data.h"

namespace waystone {

// Fills an empty file with a map. The same data give the same bytes, whatever the file is called.
// The map must have no problem (FindMapProblems). Throws SQLite::Exception, for a full disk with
// the system's message; the file is useless then. Thread-safe for different files.
void WriteDatabase(const MapData& map, const std::filesystem::path& path);

// The size that the map's file will have, in bytes, to a few per cent; for messages. Thread-safe.
int64_t EstimateBytes(const MapData& map);

}  // namespace waystone
