// SPDX-License-Identifier: Apache-2.0
#include "cli/files/map_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <system_error>

#include "core/base/error.h"
#include "core/base/text.h"
#include "schema/file/file_replacer.h"
#include "schema/file/map_store.h"

namespace waystone {
namespace {

std::string PreviousOf(const std::filesystem::path& path) { return path.string() + ".previous"; }

[[noreturn]] void RefuseFile(const std::filesystem::path& path, const std::string& cause,
                             const std::string& wanted) {
  throw MapError(ErrorCode::kFileUnreadable, path.string() + ": " + cause + "; expected " + wanted);
}

}  // namespace

std::string MapNameOf(const std::filesystem::path& path) { return path.stem().string(); }

OpenMap OpenMapFile(const std::filesystem::path& path, bool images) {
  ReadOptions options;
  options.images = images;
  return {MapNameOf(path), MapIndex::Build(ReadMap(path, options))};
}

void CheckReplaceable(const std::filesystem::path& path, bool keep) {
  CheckWritable(path, {.overwrite = true});
  if (keep) CheckWritable(PreviousOf(path), {.overwrite = true});
}

void ReplaceMap(const MapData& map, const std::filesystem::path& path, bool keep) {
  CheckReplaceable(path, keep);
  if (keep) {
    FileReplacer previous(PreviousOf(path), true);
    try {
      std::filesystem::copy_file(path, previous.temporary(),
                                 std::filesystem::copy_options::overwrite_existing);
    } catch (const std::filesystem::filesystem_error& error) {
      throw UnwritableError(PreviousOf(path), error.code().message(), 0);
    }
    previous.Commit();
  }
  WriteMap(map, path, {.overwrite = true});
}

std::ifstream OpenText(const std::filesystem::path& path, const std::string& wanted) {
  std::error_code ignored;
  const std::filesystem::file_status status = std::filesystem::status(path, ignored);
  if (std::filesystem::is_directory(status)) RefuseFile(path, std::strerror(EISDIR), wanted);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    RefuseFile(path, "is not a regular file", wanted);
  }
  std::ifstream in(path, std::ios::binary);
  if (!in) RefuseFile(path, std::strerror(errno), wanted);
  std::string start(kByteOrderMark.size(), '\0');
  if (in.read(start.data(), std::ssize(start)) && start == kByteOrderMark) return in;
  in.clear();
  in.seekg(0);
  return in;
}

std::vector<uint8_t> ReadBytes(const std::filesystem::path& path, const std::string& wanted,
                               int64_t max_bytes) {
  std::ifstream in = OpenText(path, wanted);
  const auto size = static_cast<int64_t>(in.seekg(0, std::ios::end).tellg());
  if (size > max_bytes) {
    RefuseFile(path,
               "has " + std::to_string(size) + " bytes, more than " + std::to_string(max_bytes),
               wanted);
  }
  std::vector<uint8_t> bytes(static_cast<size_t>(std::max<int64_t>(size, 0)));
  in.seekg(0).read(reinterpret_cast<char*>(bytes.data()), std::ssize(bytes));
  bytes.resize(static_cast<size_t>(in.gcount()));
  if (size < 0 || in.bad()) RefuseFile(path, "can't be read", wanted);
  return bytes;
}

}  // namespace waystone
