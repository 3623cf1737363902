// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <limits>
#include <string_view>

#include "core/base/error.h"
#include "core/image/formats.h"

namespace waystone {
namespace {

constexpr std::string_view kPngSignature = "\x89PNG\r\n\x1a\n";
constexpr std::string_view kJpegSignature = "\xff\xd8\xff";

bool StartsWith(Bytes bytes, std::string_view signature, size_t offset = 0) {
  return bytes.size() >= offset + signature.size() &&
         std::equal(signature.begin(), signature.end(), bytes.begin() + offset,
                    [](char a, uint8_t b) { return static_cast<uint8_t>(a) == b; });
}

// Callers have checked that the bytes are there.
uint32_t Little16(Bytes bytes, size_t at) { return bytes[at] | bytes[at + 1] << 8; }

uint32_t Little32(Bytes bytes, size_t at) {
  return Little16(bytes, at) | Little16(bytes, at + 2) << 16;
}

bool LooksLikeText(Bytes bytes) {
  constexpr size_t kLooked = 256;
  return std::ranges::all_of(bytes.first(std::min(bytes.size(), kLooked)), [](uint8_t byte) {
    return byte >= 0x20 || byte == '\n' || byte == '\r' || byte == '\t';
  });
}

// What bytes of no known format look like, for the message.
std::string LooksLike(Bytes bytes) {
  struct Row {
    size_t offset;
    std::string_view signature;
    std::string_view name;
  };
  static constexpr std::array kRows{
      Row{0, "GIF8", "a GIF"},          Row{0, "II*", "a TIFF"},
      Row{0, "MM", "a TIFF"},           Row{0, "%PDF", "a PDF"},
      Row{0, "PK", "a zip archive"},    Row{0, "SQLite format 3", "an SQLite database"},
      Row{0, "P1", "a plain-text PNM"}, Row{0, "P2", "a plain-text PNM"},
      Row{0, "P3", "a plain-text PNM"}, Row{0, "P4", "a black-and-white bitmap"},
  };
  for (const Row& row : kRows) {
    if (StartsWith(bytes, row.signature, row.offset)) return std::string(row.name);
  }
  return LooksLikeText(bytes) ? "text" : "no known image format";
}

}  // namespace

void RefuseImage(const std::string& message) { throw MapError(ErrorCode::kBadImage, message); }

void RefuseCutOff(const std::string& format, Bytes bytes, const std::string& missing) {
  RefuseImage("the " + format + " is truncated after " + std::to_string(bytes.size()) +
              " bytes, before " + missing + "; copy or send the whole file again");
}

ImageHeader ReadBmpHeader(Bytes bytes) {
  constexpr size_t kShortest = 54;  // file header and the oldest information header in use
  constexpr uint32_t kInfoHeader = 40;
  constexpr uint32_t kBitFields = 3;  // uncompressed, with masks
  if (bytes.size() < kShortest) RefuseCutOff("BMP", bytes, "the end of its header");
  if (Little32(bytes, 14) < kInfoHeader) RefuseImage("OS/2 BMP is not supported; save it as PNG");
  const auto width = static_cast<int32_t>(Little32(bytes, 18));
  const auto height = static_cast<int32_t>(Little32(bytes, 22));
  const uint32_t bits = Little16(bytes, 28);
  const uint32_t compression = Little32(bytes, 30);
  if (compression != 0 && compression != kBitFields) {
    RefuseImage("compressed BMP is not supported; save it as PNG");
  }
  if (width <= 0 || height == 0 || height == std::numeric_limits<int32_t>::min() || bits == 0 ||
      bits > 32) {
    RefuseImage("the BMP claims " + std::to_string(width) + "x" + std::to_string(height) +
                " pixels of " + std::to_string(bits) + " bits; it is damaged");
  }
  // Rows are padded to four bytes; a negative height means that the top row comes first.
  const int rows = std::abs(height);
  const uint64_t row_bytes = (static_cast<uint64_t>(width) * bits + 31) / 32 * 4;
  if (Little32(bytes, 10) + row_bytes * rows > bytes.size()) {
    RefuseCutOff("BMP", bytes, "the end of its pixels");
  }
  return {.format = "bmp", .width = width, .height = rows};
}

namespace {

// Numbers in a PNM header, each followed by a byte of white space. Comments run from '#' to the
// line's end, a line feed or a carriage return. Netpbm also accepts a '#' right after a number, but
// decoders disagree on where the next number then begins, so it is refused.
class PnmNumbers {
 public:
  explicit PnmNumbers(Bytes bytes) : bytes_(bytes) {
    if (position_ < bytes_.size() && !std::isspace(bytes_[position_])) {
      RefuseImage("the first two bytes of the PNM aren't followed by white space; it is damaged");
    }
  }

  int Next() {
    SkipSpace();
    constexpr int kMax = 100'000'000;
    int value = 0;
    const size_t start = position_;
    for (; position_ < bytes_.size() && std::isdigit(bytes_[position_]); ++position_) {
      value = std::min(value * 10 + (bytes_[position_] - '0'), kMax);
    }
    if (position_ >= bytes_.size()) RefuseCutOff("PNM", bytes_, "the end of its header");
    if (position_ == start) RefuseImage("a number is missing in the PNM header; it is damaged");
    if (!std::isspace(bytes_[position_])) {
      RefuseImage("a number in the PNM header isn't followed by white space; it is damaged");
    }
    ++position_;
    return value;
  }

  // The position after the white space of the last number.
  size_t position() const { return position_; }

 private:
  static bool EndsLine(uint8_t byte) { return byte == '\n' || byte == '\r'; }

  void SkipSpace() {
    while (position_ < bytes_.size()) {
      if (bytes_[position_] == '#') {
        while (position_ < bytes_.size() && !EndsLine(bytes_[position_])) ++position_;
      } else if (std::isspace(bytes_[position_])) {
        ++position_;
      } else {
        return;
      }
    }
  }

  Bytes bytes_;
  size_t position_ = 2;  // after "P5" or "P6"
};

// The header of a PNM.
struct PnmHeader {
  int width = 0;
  int height = 0;
  int maximum = 0;
  uint64_t samples = 0;
  size_t samples_at = 0;

  int sample_bytes() const { return maximum > 255 ? 2 : 1; }
};

PnmHeader ReadPnm(Bytes bytes) {
  PnmNumbers numbers(bytes);
  PnmHeader pnm;
  pnm.width = numbers.Next();
  pnm.height = numbers.Next();
  pnm.maximum = numbers.Next();
  pnm.samples = static_cast<uint64_t>(pnm.width) * pnm.height * (bytes[1] == '6' ? 3 : 1);
  pnm.samples_at = numbers.position();
  return pnm;
}

}  // namespace

ImageHeader ReadPnmHeader(Bytes bytes) {
  const PnmHeader pnm = ReadPnm(bytes);
  if (pnm.maximum < 1 || pnm.maximum > 65535) {
    RefuseImage("the maximum value of the PNM is " + std::to_string(pnm.maximum) +
                ", not 1 to 65535; it is damaged");
  }
  if (pnm.samples_at + pnm.samples * pnm.sample_bytes() > bytes.size()) {
    RefuseCutOff("PNM", bytes, "the end of its pixels");
  }
  return {.format = "pnm", .width = pnm.width, .height = pnm.height};
}

bool HasOwnMaximum(Bytes bytes) {
  const int maximum = ReadPnm(bytes).maximum;
  return maximum != 255 && maximum != 65535;
}

std::vector<uint8_t> WithMaximum255(Bytes bytes) {
  const PnmHeader pnm = ReadPnm(bytes);
  const std::string header = std::string(bytes.begin(), bytes.begin() + 2) + " " +
                             std::to_string(pnm.width) + " " + std::to_string(pnm.height) + " 255 ";
  std::vector<uint8_t> scaled(header.begin(), header.end());
  scaled.reserve(header.size() + pnm.samples);
  for (uint64_t i = 0; i < pnm.samples; ++i) {
    const size_t at = pnm.samples_at + i * pnm.sample_bytes();
    const int sample = pnm.sample_bytes() == 1 ? bytes[at] : bytes[at] << 8 | bytes[at + 1];
    scaled.push_back((std::min(sample, pnm.maximum) * 255 + pnm.maximum / 2) / pnm.maximum);
  }
  return scaled;
}

ImageHeader ReadImageHeader(Bytes bytes) {
  if (bytes.empty()) RefuseImage("the image is empty (0 bytes); copy or send it again");
  ImageHeader header;
  if (StartsWith(bytes, kJpegSignature)) {
    header = ReadJpegHeader(bytes);
  } else if (StartsWith(bytes, kPngSignature)) {
    header = ReadPngHeader(bytes);
  } else if (StartsWith(bytes, "BM")) {
    header = ReadBmpHeader(bytes);
  } else if (StartsWith(bytes, "RIFF") && StartsWith(bytes, "WEBP", 8)) {
    header = ReadWebpHeader(bytes);
  } else if (StartsWith(bytes, "ftyp", 4)) {
    header = ReadHeicHeader(bytes);
  } else if (StartsWith(bytes, "P5") || StartsWith(bytes, "P6")) {
    header = ReadPnmHeader(bytes);
  } else {
    RefuseImage("the " + std::to_string(bytes.size()) + " bytes are " + LooksLike(bytes) +
                "; supported formats are JPEG, PNG, WebP, HEIC, BMP and PNM (P5, P6)");
  }
  if (header.width < 1 || header.height < 1) {
    RefuseImage("the " + header.format + " claims " + std::to_string(header.width) + "x" +
                std::to_string(header.height) + " pixels; it is damaged");
  }
  return header;
}

}  // namespace waystone
