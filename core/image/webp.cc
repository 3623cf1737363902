// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <optional>
#include <string_view>
#include <vector>

#include "core/image/formats.h"
#include "core/image/webp_lossless.h"

namespace waystone {
namespace {

constexpr size_t kRiffHead = 12;  // "RIFF", size, "WEBP"
constexpr size_t kChunkHead = 8;  // name, size
constexpr std::string_view kLossy = "VP8 ";
constexpr std::string_view kLossless = "VP8L";

uint32_t Number(Bytes bytes, size_t at, int size) {
  uint32_t value = 0;
  for (int i = size - 1; i >= 0; --i) value = value << 8 | bytes[at + i];
  return value;
}

struct WebpChunk {
  std::string_view name;
  Bytes data;
};

// Walks over the chunks within the file's stated size; bytes after it don't belong to it.
class WebpChunks {
 public:
  explicit WebpChunks(Bytes bytes) : bytes_(bytes) {
    if (bytes.size() < kRiffHead) RefuseCutOff("WebP", bytes, "the end of its header");
    const uint64_t size = uint64_t{8} + Number(bytes, 4, 4);
    if (size > bytes.size()) RefuseCutOff("WebP", bytes, "the end of its chunks");
    end_ = std::max(static_cast<size_t>(size), kRiffHead);
  }

  std::optional<WebpChunk> Next() {
    if (end_ - position_ < kChunkHead) return std::nullopt;
    const std::string_view name(reinterpret_cast<const char*>(&bytes_[position_]), 4);
    const size_t size = Number(bytes_, position_ + 4, 4);
    if (end_ - position_ - kChunkHead < size) {
      RefuseImage("a chunk of the WebP is longer than the file says; it is damaged");
    }
    const Bytes data = bytes_.subspan(position_ + kChunkHead, size);
    position_ = std::min(end_, position_ + kChunkHead + size + size % 2);
    return WebpChunk{name, data};
  }

 private:
  Bytes bytes_;
  size_t position_ = kRiffHead;
  size_t end_ = 0;
};

ImageHeader ReadKeyFrame(Bytes frame) {
  constexpr size_t kFrameHead = 10;
  constexpr uint32_t kStartCode = 0x2A019D;
  constexpr uint32_t kSize = 0x3FFF;  // the upper two bits are a scale that decoders ignore
  if (frame.size() < kFrameHead || frame[0] % 2 != 0 || Number(frame, 3, 3) != kStartCode) {
    RefuseImage("the WebP has no key frame; it is damaged");
  }
  return {.format = "webp",
          .width = static_cast<int>(Number(frame, 6, 2) & kSize),
          .height = static_cast<int>(Number(frame, 8, 2) & kSize)};
}

// A lossless image is decoded as a whole, with tables for each group of codes; 20 bits of the file
// suffice for a group.
ImageHeader ReadLossless(Bytes data) {
  constexpr int64_t kGroupBytes = 13'000;
  constexpr int kPixelBytes = 9;  // decoded, converted to BGR with alpha, and grey
  const LosslessWebp image = ReadLosslessWebp(data);
  const int64_t pixels = int64_t{image.width} * image.height;
  return {.format = "webp",
          .width = image.width,
          .height = image.height,
          .decode_bytes = kPixelBytes * pixels + kGroupBytes * image.groups};
}

struct WebpParts {
  ImageHeader header;
  std::string_view name;
  Bytes frame;  // the image
  Bytes exif;
};

WebpParts ReadParts(Bytes bytes) {
  WebpChunks chunks(bytes);
  WebpParts parts;
  ImageHeader canvas;
  while (const std::optional<WebpChunk> chunk = chunks.Next()) {
    const bool lossy = chunk->name == kLossy;
    if ((lossy || chunk->name == kLossless) && parts.frame.empty()) {
      parts.header = lossy ? ReadKeyFrame(chunk->data) : ReadLossless(chunk->data);
      parts.name = chunk->name;
      parts.frame = chunk->data;
    } else if (chunk->name == "ANIM" || chunk->name == "ANMF") {
      RefuseImage("the WebP is animated; save one of its frames as JPEG or PNG");
    } else if (chunk->name == "VP8X" && chunk->data.size() >= 10) {
      canvas.width = static_cast<int>(Number(chunk->data, 4, 3)) + 1;
      canvas.height = static_cast<int>(Number(chunk->data, 7, 3)) + 1;
    } else if (chunk->name == "EXIF" && parts.exif.empty()) {
      parts.exif = chunk->data;
    }
  }
  if (parts.frame.empty()) RefuseImage("the WebP has no image data; it is damaged");
  const ImageHeader& header = parts.header;
  if (canvas.width > 0 && (canvas.width != header.width || canvas.height != header.height)) {
    RefuseImage("the WebP claims " + std::to_string(canvas.width) + "x" +
                std::to_string(canvas.height) + " pixels, but its image has " +
                std::to_string(header.width) + "x" + std::to_string(header.height) +
                "; it is damaged");
  }
  return parts;
}

}  // namespace

ImageHeader ReadWebpHeader(Bytes bytes) { return ReadParts(bytes).header; }

Bytes WebpExif(Bytes bytes) { return ReadParts(bytes).exif; }

std::vector<uint8_t> BareWebp(Bytes bytes) {
  const WebpParts parts = ReadParts(bytes);
  const Bytes frame = parts.frame;
  std::vector<uint8_t> bare;
  const auto text = [&bare](std::string_view name) {
    bare.insert(bare.end(), name.begin(), name.end());
  };
  const auto number = [&bare](size_t value) {
    for (int i = 0; i < 4; ++i) bare.push_back(static_cast<uint8_t>(value >> 8 * i));
  };
  bare.reserve(kRiffHead + kChunkHead + frame.size() + 1);
  text("RIFF");
  number(4 + kChunkHead + frame.size() + frame.size() % 2);
  text("WEBP");
  text(parts.name);
  number(frame.size());
  bare.insert(bare.end(), frame.begin(), frame.end());
  if (frame.size() % 2 != 0) bare.push_back(0);
  return bare;
}

}  // namespace waystone
