// SPDX-License-Identifier: Apache-2.0
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "core/base/text.h"
#include "core/image/formats.h"

namespace waystone {
namespace {

constexpr size_t kSignatureBytes = 8;
constexpr size_t kFrameBytes = 12;  // of a chunk: length, name, checksum

uint32_t BigEndian32(Bytes bytes, size_t at) {
  return static_cast<uint32_t>(bytes[at]) << 24 | bytes[at + 1] << 16 | bytes[at + 2] << 8 |
         bytes[at + 3];
}

struct PngChunk {
  std::string_view name;
  Bytes data;
  Bytes whole;  // with length, name and checksum
};

// Walks over the chunks up to the last one, IEND.
class PngChunks {
 public:
  explicit PngChunks(Bytes bytes) : bytes_(bytes) {}

  std::optional<PngChunk> Next() {
    if (ended_) return std::nullopt;
    const size_t left = bytes_.size() - position_;
    if (left < kFrameBytes) RefuseCutOff("PNG", bytes_, "its end chunk");
    const uint32_t length = BigEndian32(bytes_, position_);
    const std::string_view name(reinterpret_cast<const char*>(&bytes_[position_ + 4]), 4);
    if (position_ == kSignatureBytes && (length != 13 || name != "IHDR")) {
      RefuseImage("the PNG does not start with a header chunk; it is damaged");
    }
    if (left - kFrameBytes < length) RefuseCutOff("PNG", bytes_, "its end chunk");
    const Bytes whole = bytes_.subspan(position_, kFrameBytes + length);
    position_ += whole.size();
    ended_ = name == "IEND";
    return PngChunk{name, whole.subspan(8, length), whole};
  }

 private:
  Bytes bytes_;
  size_t position_ = kSignatureBytes;
  bool ended_ = false;
};

// Bits of a pixel by colour type and depth; 0 for an invalid combination.
int BitsOfPixel(int colour_type, int depth) {
  const bool power = depth == 1 || depth == 2 || depth == 4 || depth == 8 || depth == 16;
  constexpr std::array kChannels{1, 0, 3, 1, 2, 0, 4};
  const int channels = colour_type <= 6 ? kChannels.at(colour_type) : 0;
  const bool packed = colour_type == 0 || colour_type == 3;
  if (!power || (!packed && depth < 8) || (colour_type == 3 && depth > 8)) return 0;
  return channels * depth;
}

struct PngSize {
  int width = 0;
  int height = 0;
  int64_t pixel_bytes = 0;  // what the data inflate to, interlaced or not, at most
};

PngSize ReadSize(Bytes header) {
  constexpr uint32_t kMaxSide = std::numeric_limits<int>::max();
  constexpr int64_t kMaxPixelBytes = std::numeric_limits<int64_t>::max() / 4;
  PngSize size;
  size.width = static_cast<int>(std::min(BigEndian32(header, 0), kMaxSide));
  size.height = static_cast<int>(std::min(BigEndian32(header, 4), kMaxSide));
  const int bits = BitsOfPixel(header[9], header[8]);
  if (bits == 0) {
    RefuseImage("the PNG claims colour type " + std::to_string(header[9]) + " with " +
                std::to_string(header[8]) + " bits; it is damaged");
  }
  // A byte per row for its filter, and up to two more for interlaced rows.
  const int64_t row_bytes = static_cast<int64_t>(size.width) * bits / 8 + 1;
  const bool huge = row_bytes > kMaxPixelBytes / std::max(1, size.height);
  size.pixel_bytes = huge ? kMaxPixelBytes : (row_bytes + 3) * size.height;
  return size;
}

std::string MegabytesText(int64_t bytes) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f MB", static_cast<double>(bytes) / 1e6);
  return text.data();
}

// Counts the blocks of a PNG's deflate stream up to the end of its pixels, at most `most`. Damage
// is left to the decoder.
int64_t CountBlocks(Bytes bytes, int64_t pixel_bytes, int64_t most) {
  constexpr int kBehindBlock = 128;
  std::vector<Bytef> inflated(1 << 16);
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) return 0;
  PngChunks chunks(bytes);
  int64_t blocks = 0;
  while (blocks < most && static_cast<int64_t>(stream.total_out) < pixel_bytes) {
    if (stream.avail_in == 0) {
      const std::optional<PngChunk> chunk = chunks.Next();
      if (!chunk) break;
      if (chunk->name != "IDAT") continue;
      stream.next_in = const_cast<Bytef*>(chunk->data.data());  // zlib doesn't change it
      stream.avail_in = static_cast<uInt>(chunk->data.size());
      continue;
    }
    stream.next_out = inflated.data();
    stream.avail_out = static_cast<uInt>(inflated.size());
    if (inflate(&stream, Z_BLOCK) != Z_OK) break;
    blocks += (stream.data_type & kBehindBlock) != 0;
  }
  inflateEnd(&stream);
  return blocks;
}

void CheckDataBytes(int64_t bytes, const PngSize& size) {
  constexpr int64_t kSlack = 1 << 16;
  const int64_t most = size.pixel_bytes + size.pixel_bytes / 8 + kSlack;
  if (bytes <= most) return;
  RefuseImage("the PNG has " + MegabytesText(bytes) + " of image data, but " +
              std::to_string(size.width) + "x" + std::to_string(size.height) +
              " pixels need at most " + MegabytesText(most) + "; save it again");
}

bool IsText(const PngChunk& chunk) {
  return chunk.name == "tEXt" || chunk.name == "zTXt" || chunk.name == "iTXt";
}

struct PngData {
  PngSize size;
  bool found = false;  // a chunk of image data
  int64_t bytes = 0;   // of all of them
};

PngData MeasureData(Bytes bytes) {
  PngChunks chunks(bytes);
  PngData data{.size = ReadSize(chunks.Next()->data)};
  while (const std::optional<PngChunk> chunk = chunks.Next()) {
    if (chunk->name != "IDAT") continue;
    data.found = true;
    data.bytes += std::ssize(chunk->data);
  }
  return data;
}

}  // namespace

ImageHeader ReadPngHeader(Bytes bytes) {
  const PngData data = MeasureData(bytes);
  if (!data.found) RefuseImage("the PNG has no image data; it is damaged");
  CheckDataBytes(data.bytes, data.size);
  return {.format = "png",
          .width = data.size.width,
          .height = data.size.height,
          .inflated_bytes = data.size.pixel_bytes};
}

void CheckPngBlocks(Bytes bytes) {
  constexpr int64_t kFewBytes = 4'000'000;  // half a second at worst
  constexpr int64_t kBytesOfBlock = 256;
  const PngData data = MeasureData(bytes);
  if (data.bytes <= kFewBytes) return;
  const int64_t most = 1000 + int64_t{2} * data.size.height + data.bytes / kBytesOfBlock;
  if (CountBlocks(bytes, data.size.pixel_bytes, most + 1) <= most) return;
  RefuseImage("the PNG has more than " + std::to_string(most) +
              " blocks of compressed data, far more than its " + std::to_string(data.size.height) +
              " rows need; save it again");
}

void CheckPngChecksums(Bytes bytes) {
  PngChunks chunks(bytes);
  while (const std::optional<PngChunk> chunk = chunks.Next()) {
    // The decoder skips a damaged chunk whose name starts with a small letter: it is optional.
    const bool needed = chunk->name[0] >= 'A' && chunk->name[0] <= 'Z';
    const Bytes summed = chunk->whole.subspan(4, 4 + chunk->data.size());
    const uLong sum = crc32(0, summed.data(), static_cast<uInt>(summed.size()));
    if (!needed || sum == BigEndian32(chunk->whole, 8 + chunk->data.size())) continue;
    RefuseImage("the PNG is damaged: the checksum of its chunk " + Printable(chunk->name) +
                " is wrong; copy or send the file again");
  }
}

bool HasPngTexts(Bytes bytes) {
  PngChunks chunks(bytes);
  while (const std::optional<PngChunk> chunk = chunks.Next()) {
    if (IsText(*chunk)) return true;
  }
  return false;
}

std::vector<uint8_t> WithoutPngTexts(Bytes bytes) {
  std::vector<uint8_t> taken(bytes.begin(), bytes.begin() + kSignatureBytes);
  PngChunks chunks(bytes);
  while (const std::optional<PngChunk> chunk = chunks.Next()) {
    if (IsText(*chunk)) continue;
    taken.insert(taken.end(), chunk->whole.begin(), chunk->whole.end());
  }
  return taken;
}

}  // namespace waystone
