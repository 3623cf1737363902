// SPDX-License-Identifier: Apache-2.0
#include "core/image/exif.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string_view>

#include "core/base/error.h"
#include "core/image/decode.h"
#include "core/image/formats.h"
#include "core/image/heic.h"

namespace waystone {
namespace {

constexpr double kFilmDiagonalMm = 43.266615305567875;  // of 24 x 36 mm
constexpr double kMinFocalMm = 3;
constexpr double kMaxFocalMm = 3000;
constexpr double kMaxShapeError = 0.01;  // of the sides' ratio: scaled sides are rounded

enum Tag : uint32_t {
  kOrientation = 0x0112,
  kExifDirectory = 0x8769,
  kPixelWidth = 0xA002,
  kPixelHeight = 0xA003,
  kFocal35mm = 0xA405,
};

// The TIFF structure inside EXIF data: directories of entries of 12 bytes.
class Tiff {
 public:
  explicit Tiff(Bytes bytes) : bytes_(bytes) {}

  // The byte order; false for what is no TIFF.
  bool ReadStart() {
    if (bytes_.size() < 8 || bytes_[0] != bytes_[1]) return false;
    big_ = bytes_[0] == 'M';
    return (big_ || bytes_[0] == 'I') && Read(2, 2) == 42;
  }
  std::optional<uint32_t> FirstDirectory() const { return Read(4, 4); }

  // The value of an integer tag in a directory. Each directory is scanned once per tag, and cycles
  // of directories are not followed: hostile data costs nothing.
  std::optional<uint32_t> Whole(uint32_t directory, uint32_t tag) const {
    constexpr uint32_t kShort = 3;
    constexpr uint32_t kLong = 4;
    const std::optional<uint32_t> count = Read(directory, 2);
    if (!count) return std::nullopt;
    for (uint32_t i = 0; i < *count; ++i) {
      const size_t entry = size_t{directory} + 2 + size_t{12} * i;
      const std::optional<uint32_t> name = Read(entry, 2);
      if (!name) return std::nullopt;
      if (*name != tag) continue;
      const std::optional<uint32_t> type = Read(entry + 2, 2);
      if (type == kShort) return Read(entry + 8, 2);
      if (type == kLong) return Read(entry + 8, 4);
      return std::nullopt;
    }
    return std::nullopt;
  }

 private:
  // `size` bytes as a number; nothing when they aren't all there.
  std::optional<uint32_t> Read(size_t at, size_t size) const {
    if (at > bytes_.size() || bytes_.size() - at < size) return std::nullopt;
    uint32_t value = 0;
    for (size_t i = 0; i < size; ++i) {
      value = value << 8 | bytes_[big_ ? at + i : at + size - 1 - i];
    }
    return value;
  }

  Bytes bytes_;
  bool big_ = false;
};

// What the segments before the image data hold.
struct Segments {
  Bytes exif;  // the TIFF
  int width = 0;
  int height = 0;
};

// Markers without a length, and SOS, at which the segments end.
bool StandsAlone(int marker) {
  return marker <= 0x01 || (marker >= 0xD0 && marker <= 0xDA) || marker == 0xFF;
}

constexpr std::string_view kExif("Exif\0\0", 6);

bool IsNamedExif(Bytes bytes) {
  return bytes.size() > kExif.size() &&
         std::equal(kExif.begin(), kExif.end(), bytes.begin(),
                    [](char a, uint8_t b) { return static_cast<uint8_t>(a) == b; });
}

Segments ReadSegments(Bytes bytes) {
  Segments found;
  size_t at = 2;
  while (bytes.size() > at && bytes.size() - at >= 4 && bytes[at] == 0xFF) {
    const int marker = bytes[at + 1];
    if (StandsAlone(marker)) break;
    const size_t length = bytes[at + 2] * 256 + bytes[at + 3];
    if (length < 2 || bytes.size() - at - 2 < length) break;
    const Bytes segment = bytes.subspan(at + 4, length - 2);
    const bool frame =
        marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (frame) {
      if (segment.size() < 6) break;
      found.height = segment[1] * 256 + segment[2];
      found.width = segment[3] * 256 + segment[4];
      break;
    }
    const bool exif = marker == 0xE1 && IsNamedExif(segment);
    if (exif && found.exif.empty()) found.exif = segment.subspan(kExif.size());
    at += 2 + length;
  }
  return found;
}

// The same for a WebP or HEIC, whose whole header is read; nothing for one that can't be read.
Segments ReadContainer(Bytes bytes) {
  const bool webp = bytes[0] == 'R' && bytes[1] == 'I';
  const bool heic = bytes.size() >= 8 && bytes[4] == 'f' && bytes[5] == 't';
  if (!webp && !heic) return {};
  try {
    const ImageHeader header = ReadImageHeader(bytes);
    Segments found;
    found.width = header.width;
    found.height = header.height;
    if (header.format == "webp") found.exif = WebpExif(bytes);
    if (header.format == "heic") found.exif = HeicExif(bytes);
    if (IsNamedExif(found.exif)) found.exif = found.exif.subspan(kExif.size());
    return found;
  } catch (const MapError&) {
    return {};
  }
}

Segments ReadExif(Bytes bytes) {
  if (bytes.size() < 4) return {};
  const bool jpeg = bytes[0] == 0xFF && bytes[1] == 0xD8;
  return jpeg ? ReadSegments(bytes) : ReadContainer(bytes);
}

bool SameShape(double width, double height, double other_width, double other_height) {
  const double error = width * other_height / (height * other_width) - 1;
  return std::abs(error) <= kMaxShapeError;
}

}  // namespace

std::optional<ExifCamera> ReadExifCamera(Bytes bytes) {
  const Segments segments = ReadExif(bytes);
  if (segments.exif.empty() || segments.width < 1 || segments.height < 1) return std::nullopt;
  Tiff tiff(segments.exif);
  if (!tiff.ReadStart()) return std::nullopt;
  const std::optional<uint32_t> first = tiff.FirstDirectory();
  const std::optional<uint32_t> exif = first ? tiff.Whole(*first, kExifDirectory) : std::nullopt;
  if (!exif) return std::nullopt;
  const std::optional<uint32_t> focal_mm = tiff.Whole(*exif, kFocal35mm);
  if (!focal_mm || *focal_mm < kMinFocalMm || *focal_mm > kMaxFocalMm) return std::nullopt;
  const uint32_t width = tiff.Whole(*exif, kPixelWidth).value_or(0);
  const uint32_t height = tiff.Whole(*exif, kPixelHeight).value_or(0);
  if (width > 0 && height > 0 && !SameShape(segments.width, segments.height, width, height)) {
    return std::nullopt;
  }
  const double diagonal_px = std::hypot(segments.width, segments.height);
  return ExifCamera{segments.width, segments.height, *focal_mm / kFilmDiagonalMm * diagonal_px};
}

int ReadExifOrientation(Bytes bytes) {
  Tiff tiff(ReadExif(bytes).exif);
  if (!tiff.ReadStart()) return 1;
  const std::optional<uint32_t> first = tiff.FirstDirectory();
  const uint32_t value = first ? tiff.Whole(*first, kOrientation).value_or(1) : 1;
  return value >= 1 && value <= 8 ? static_cast<int>(value) : 1;
}

}  // namespace waystone
