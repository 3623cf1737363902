// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "localizer/index/map_index.h"

namespace waystone {

// A map that was given to the program as a file.
struct OpenMap {
  std::string name;  // the file's, without folder and extension: what answers and URLs call it
  std::shared_ptr<const MapIndex> index;
};

// The name that a map gets from its file.
std::string MapNameOf(const std::filesystem::path& path);

// Reads a map file and makes it ready for queries. Throws as ReadMap does.
OpenMap OpenMapFile(const std::filesystem::path& path, bool images);

// Replaces the file that the map came from, as a whole or not at all. With `keep`, the previous one
// becomes PATH.previous, replacing a map that has this name. Throws as WriteMap and FileReplacer
// do.
void ReplaceMap(const MapData& map, const std::filesystem::path& path, bool keep);

// Throws what ReplaceMap would throw for these paths. To be called before the work, not after.
void CheckReplaceable(const std::filesystem::path& path, bool keep);

// Bound on a file that is read at once: the largest request that a server can be told to accept.
inline constexpr int64_t kMaxReadBytes = 400'000'000;

// The bytes of a file. Throws MapError(kFileUnreadable), with the cause and with `wanted` as what
// to give; also for anything but a regular file, since a pipe or device might never end, and for
// one larger than `max_bytes`.
std::vector<uint8_t> ReadBytes(const std::filesystem::path& path,
                               const std::string& wanted = "an image file",
                               int64_t max_bytes = kMaxReadBytes);

// Opens a text file, behind its byte order mark if there is one. Throws as ReadBytes does; a text
// may be of any length.
std::ifstream OpenText(const std::filesystem::path& path, const std::string& wanted);

}  // namespace waystone
