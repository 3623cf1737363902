// SPDX-License-Identifier: Apache-2.0
#include "builder/sources/files.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

#include "core/base/text.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kMaxTextBytes = 64 << 20;  // a list of a million frames

}  // namespace

std::vector<uint8_t> ReadFile(const fs::path& path, int64_t max_bytes, ErrorCode code) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) {
    throw MapError(code, Quoted(path) + " does not exist; check the path");
  }
  if (!fs::status_known(status)) {  // a link to itself
    throw MapError(code, Quoted(path) + " can't be read: " + error.message());
  }
  // A pipe or a device might never end.
  if (!fs::is_regular_file(status)) throw MapError(code, Quoted(path) + " is not a regular file");
  const auto size = static_cast<int64_t>(fs::file_size(path, error));
  if (!error && size > max_bytes) {
    throw MapError(code, Quoted(path) + " has " + std::to_string(size) + " bytes; the limit is " +
                             std::to_string(max_bytes));
  }
  std::ifstream file(path, std::ios::binary);
  std::vector<uint8_t> bytes(error ? 0 : size);
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (error || !file) {
    throw MapError(
        code, Quoted(path) + " can't be read: " + (error ? error.message() : std::strerror(errno)));
  }
  return bytes;
}

std::vector<uint8_t> ReadImageFile(const fs::path& path, const DecodeLimits& limits,
                                   ErrorCode code) {
  constexpr int64_t kPixelBytes = 6;        // 16 bits in three colours
  constexpr int64_t kOtherBytes = 1 << 20;  // headers and thumbnails
  return ReadFile(path, limits.max_pixels * kPixelBytes + kOtherBytes, code);
}

std::string ReadText(const fs::path& path, int64_t max_bytes, ErrorCode code) {
  const std::vector<uint8_t> bytes = ReadFile(path, max_bytes, code);
  std::string text(bytes.begin(), bytes.end());
  if (text.starts_with(kByteOrderMark)) text.erase(0, kByteOrderMark.size());
  return text;
}

std::vector<TextLine> ReadLines(const fs::path& path, ErrorCode code) {
  std::istringstream stream(ReadText(path, kMaxTextBytes, code));
  std::vector<TextLine> lines;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    const std::string_view text = Trimmed(std::string_view(line).substr(0, line.find('#')));
    if (!text.empty()) lines.push_back({number, std::string(text)});
  }
  return lines;
}

std::string Quoted(const fs::path& path) {
  std::string quoted = "'";
  quoted += path.string();
  quoted += '\'';
  return quoted;
}

}  // namespace waystone
