// SPDX-License-Identifier: Apache-2.0
#include "cli/files/kept_names.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>

#include "api/names_file.h"
#include "cli/files/map_file.h"
#include "core/base/error.h"
#include "schema/file/file_replacer.h"
#include "schema/file/map_store.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

// The places of a names file that a map has, and whether these are all of them.
std::pair<std::vector<NamedPlace>, bool> PlacesIn(const std::string& names, const MapData& map) {
  try {
    ReadNames read = ReadNamesFile(names, map);
    return {std::move(read.places), read.misfits.empty()};
  } catch (const MapError& error) {
    if (error.code() != ErrorCode::kNotAvailable) throw;
    return {{}, false};
  }
}

fs::path FreeName(const fs::path& map) {
  const fs::path stem = map.parent_path() / (MapNameOf(map) + ".names");
  fs::path path = stem.string() + ".json";
  for (int number = 2; fs::exists(path); ++number) {
    path = stem.string() + "-" + std::to_string(number) + ".json";
  }
  return path;
}

}  // namespace

std::optional<std::string> NamesOfOldMap(const fs::path& path) {
  const MapData map = ReadMap(path, {.images = false});
  if (map.names.empty()) return std::nullopt;
  return Dump(NamesFileJson(MapNameOf(path), map));
}

std::optional<fs::path> KeepNames(const std::string& names, const fs::path& path, MapData& map) {
  auto [places, all] = PlacesIn(names, map);
  map.names = std::move(places);
  if (all) return std::nullopt;
  const fs::path beside = FreeName(path);
  FileReplacer file(beside, false);
  std::ofstream out(file.temporary(), std::ios::binary);
  if (!(out << names << '\n').flush()) throw UnwritableError(beside, std::strerror(errno), 0);
  file.Commit();
  return beside;
}

}  // namespace waystone
