// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "schema/map_data.h"

// Names that people gave to places outlive the map that they were given to.
namespace waystone {

// The names of the map at `path` as a names file; nothing where it has none. Throws MapError for a
// map that can't be read.
std::optional<std::string> NamesOfOldMap(const std::filesystem::path& path);

// Puts those places of a names file that `map` has into it. If it doesn't have all of them, the
// file is written beside `path`, where the map goes, under a free name, which is returned. Throws
// MapError(kFileUnwritable).
std::optional<std::filesystem::path> KeepNames(const std::string& names,
                                               const std::filesystem::path& path, MapData& map);

}  // namespace waystone
