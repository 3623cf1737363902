// SPDX-License-Identifier: Apache-2.0
#include "builder/sources/edit_list.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

namespace waystone {
namespace {

constexpr uint64_t kMostIndexBytes = 256 << 20;  // of hours of video: a few megabytes
constexpr size_t kBoxHeader = 8;

// Empty unless all of them are there.
std::string_view BytesAt(std::string_view bytes, size_t at, size_t size) {
  if (at > bytes.size() || size > bytes.size() - at) return {};
  return bytes.substr(at, size);
}

// Big-endian; 0 beyond the end.
uint64_t NumberAt(std::string_view bytes, size_t at, size_t size) {
  uint64_t number = 0;
  for (const char byte : BytesAt(bytes, at, size)) {
    number = number << 8 | static_cast<uint8_t>(byte);
  }
  return number;
}

// The content of the first box with this name after `from`, which then is behind it.
std::optional<std::string_view> NextBox(std::string_view boxes, std::string_view name,
                                        size_t& from) {
  while (boxes.size() >= kBoxHeader && from <= boxes.size() - kBoxHeader) {
    const uint64_t size = NumberAt(boxes, from, 4);
    if (size < kBoxHeader || size > boxes.size() - from) return std::nullopt;
    const std::string_view box = boxes.substr(from, size);
    from += size;
    if (box.substr(4, 4) == name) return box.substr(kBoxHeader);
  }
  return std::nullopt;
}

// Empty where there is none.
std::string_view Box(std::string_view boxes, std::string_view name) {
  size_t from = 0;
  return NextBox(boxes, name, from).value_or(std::string_view());
}

// The box `moov` of a file, which may be at its end; empty for other files.
std::string ReadIndex(std::ifstream& file, uint64_t file_bytes) {
  constexpr size_t kLongHeader = 16;
  constexpr int kMostBoxes = 1'000'000;  // fragments of hours
  uint64_t start = 0;
  for (int i = 0; i < kMostBoxes && start < file_bytes; ++i) {
    std::string header(kLongHeader, '\0');
    file.seekg(static_cast<std::streamoff>(start)).read(header.data(), kBoxHeader);
    const bool is_long = NumberAt(header, 0, 4) == 1;
    if (is_long) file.read(header.data() + kBoxHeader, kBoxHeader);
    const size_t head = is_long ? kLongHeader : kBoxHeader;
    const uint64_t size = is_long ? NumberAt(header, kBoxHeader, 8) : NumberAt(header, 0, 4);
    if (!file || size < head || size > file_bytes - start) return {};
    if (BytesAt(header, 4, 4) == "moov") {
      if (size > kMostIndexBytes) return {};
      std::string index(size - head, '\0');
      file.read(index.data(), static_cast<std::streamsize>(index.size()));
      return index;
    }
    start += size;
  }
  return {};
}

// "Full" boxes begin with a version, which tells the size of times in them.
bool IsWide(std::string_view box) { return NumberAt(box, 0, 1) == 1; }

// Of the boxes mvhd and mdhd, which begin alike, in seconds; 0 where it isn't known.
struct MediaTimes {
  double units_per_s = 0;
  double duration_s = 0;
};

MediaTimes TimesIn(std::string_view box) {
  const bool wide = IsWide(box);
  const auto units = static_cast<double>(NumberAt(box, wide ? 20 : 12, 4));
  const auto duration = static_cast<double>(NumberAt(box, wide ? 24 : 16, wide ? 8 : 4));
  return {units, units > 0 ? duration / units : 0};
}

// How much of a track its edit list plays, in seconds; nothing without a list.
std::optional<double> PlayedSeconds(std::string_view track, double units_per_s) {
  const std::string_view list = Box(Box(track, "edts"), "elst");
  const size_t field = IsWide(list) ? 8 : 4;
  const size_t entry = 2 * field + 4;
  double played = 0;
  const size_t count = NumberAt(list, 4, 4);
  for (size_t i = 0; i < count && (i + 1) * entry + 8 <= list.size(); ++i) {
    const size_t at = 8 + i * entry;
    const uint64_t duration = NumberAt(list, at, field);
    const bool is_pause = NumberAt(list, at + field, 1) == 0xff;  // time -1
    if (duration == 0) return std::nullopt;                       // to the end
    if (!is_pause) played += static_cast<double>(duration);
  }
  if (played == 0 || units_per_s == 0) return std::nullopt;
  return played / units_per_s;
}

}  // namespace

double PlayedShare(const std::filesystem::path& video) {
  std::error_code error;
  const uint64_t bytes = std::filesystem::file_size(video, error);
  std::ifstream file(video, std::ios::binary);
  if (error || !file) return 1;
  const std::string index = ReadIndex(file, bytes);
  const double movie_units_per_s = TimesIn(Box(index, "mvhd")).units_per_s;
  size_t from = 0;
  while (const auto track = NextBox(index, "trak", from)) {
    const std::string_view media = Box(*track, "mdia");
    if (BytesAt(Box(media, "hdlr"), 8, 4) != "vide") continue;
    const double duration_s = TimesIn(Box(media, "mdhd")).duration_s;
    const auto played_s = PlayedSeconds(*track, movie_units_per_s);
    return played_s && duration_s > 0 ? std::min(1.0, *played_s / duration_s) : 1;
  }
  return 1;
}

}  // namespace waystone
