// SPDX-License-Identifier: Apache-2.0
#include "cli/files/map_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include "core/base/error.h"
#include "schema/file/file_replacer.h"
#include "schema/file/map_store.h"

namespace waystone {

std::string MapNameOf(const std::filesystem::path& path) { return path.stem().string(); }

OpenMap OpenMapFile(const std::filesystem::path& path, bool images) {
  ReadOptions options;
  options.images = images;
  return {MapNameOf(path), MapIndex::Build(ReadMap(path, options))};
}

namespace {

std::string PreviousOf(const std::filesystem::path& path) { return path.string() + ".previous"; }

}  // namespace

void CheckReplaceable(const std::filesystem::path& path, bool keep) {
  CheckWritable(path, {.overwrite = true});
  if (keep) CheckWritable(PreviousOf(path), {.overwrite = true});
}

void ReplaceMap(const MapData& map, const std::filesystem::path& path, bool keep) {
  CheckReplaceable(path, keep);
  if (keep) {
    FileReplacer previous(PreviousOf(path), true);
    std::filesystem::copy_file(path, previous.temporary(),
                               std::filesystem::copy_options::overwrite_existing);
    previous.Commit();
  }
  WriteMap(map, path, {.overwrite = true});
}

std::vector<uint8_t> ReadBytes(const std::filesystem::path& path, const std::string& wanted) {
  errno = 0;
  if (std::filesystem::is_directory(path)) errno = EISDIR;
  std::ifstream in(path, std::ios::binary);
  if (!in || errno == EISDIR) {
    throw MapError(ErrorCode::kFileUnreadable,
                   path.string() + ": " + std::strerror(errno) + "; expected " + wanted);
  }
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace waystone
