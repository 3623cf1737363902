// SPDX-License-Identifier: Apache-2.0
// Follows the WebP lossless bitstream specification (RFC 9649, section 3).
#include "core/image/webp_lossless.h"

#include <algorithm>
#include <array>

namespace waystone {
namespace {

constexpr int kLiterals = 256;
constexpr int kLengths = 24;
constexpr int kDistances = 40;
constexpr int kMaxCacheBits = 11;
constexpr int kMaxSymbols = kLiterals + kLengths + (1 << kMaxCacheBits);
constexpr int kMaxLength = 15;  // of a code, bits

[[noreturn]] void RefuseLossless() {
  RefuseImage("the lossless WebP is damaged; copy or send the file again");
}

// The lowest bit of a byte comes first.
class LosslessBits {
 public:
  explicit LosslessBits(Bytes bytes) : bytes_(bytes) {}

  uint32_t Take(int count) {
    uint32_t value = 0;
    for (int i = 0; i < count; ++i, ++at_) {
      if (at_ / 8 >= bytes_.size()) RefuseLossless();
      value |= uint32_t{1} * (bytes_[at_ / 8] >> at_ % 8 & 1) << i;
    }
    return value;
  }

 private:
  Bytes bytes_;
  size_t at_ = 0;  // bits
};

// A canonical prefix code, decoded bit by bit.
class PrefixCode {
 public:
  // From the lengths of its symbols' codes; 0 for symbols without one.
  explicit PrefixCode(std::span<const uint8_t> lengths) {
    for (const uint8_t length : lengths) ++counts_[length];
    counts_[0] = 0;
    std::array<int, kMaxLength + 2> starts{};
    for (int i = 1; i <= kMaxLength; ++i) starts[i + 1] = starts[i] + counts_[i];
    const int used = starts[kMaxLength + 1];
    for (size_t i = 0; i < lengths.size(); ++i) {
      if (lengths[i] > 0) symbols_[starts[lengths[i]]++] = static_cast<uint16_t>(i);
    }
    single_ = used == 1;
    int open = 1;
    for (int i = 1; i <= kMaxLength; ++i) open = 2 * open - counts_[i];
    const bool over = open < 0;
    if (used == 0 || (!single_ && (over || open != 0))) RefuseLossless();
  }

  int Take(LosslessBits& bits) const {
    if (single_) return symbols_[0];
    int code = 0;
    int first = 0;
    int index = 0;
    for (int i = 1; i <= kMaxLength; ++i) {
      code |= static_cast<int>(bits.Take(1));
      if (code - first < counts_[i]) return symbols_[index + code - first];
      index += counts_[i];
      first = (first + counts_[i]) << 1;
      code <<= 1;
    }
    RefuseLossless();
  }

 private:
  std::array<int, kMaxLength + 1> counts_{};
  std::array<uint16_t, kMaxSymbols> symbols_{};
  bool single_ = false;
};

PrefixCode TakeCode(LosslessBits& bits, int symbols) {
  std::array<uint8_t, kMaxSymbols> lengths{};
  const std::span<const uint8_t> used(lengths.data(), symbols);
  if (bits.Take(1) != 0) {
    const bool two = bits.Take(1) != 0;
    const bool wide = bits.Take(1) != 0;
    lengths[bits.Take(wide ? 8 : 1)] = 1;
    if (two) lengths[bits.Take(8)] = 1;
    return PrefixCode(used.first(std::max(symbols, 1)));
  }
  constexpr std::array<uint8_t, 19> kOrder{17, 18, 0, 1,  2,  3,  4,  5,  16, 6,
                                           7,  8,  9, 10, 11, 12, 13, 14, 15};
  std::array<uint8_t, 19> of_lengths{};
  const int count = 4 + static_cast<int>(bits.Take(4));
  for (int i = 0; i < count; ++i) of_lengths[kOrder[i]] = static_cast<uint8_t>(bits.Take(3));
  const PrefixCode code(of_lengths);
  int left = symbols;
  if (bits.Take(1) != 0) {
    const int size = 2 + 2 * static_cast<int>(bits.Take(3));
    left = 2 + static_cast<int>(bits.Take(size));
    if (left > symbols) RefuseLossless();
  }
  uint8_t previous = 8;
  for (int at = 0; at < symbols && left > 0; --left) {
    const int taken = code.Take(bits);
    if (taken < 16) {
      lengths[at++] = static_cast<uint8_t>(taken);
      if (taken > 0) previous = static_cast<uint8_t>(taken);
      continue;
    }
    const uint8_t repeated = taken == 16 ? previous : 0;
    const int times = taken == 16   ? 3 + static_cast<int>(bits.Take(2))
                      : taken == 17 ? 3 + static_cast<int>(bits.Take(3))
                                    : 11 + static_cast<int>(bits.Take(7));
    if (at + times > symbols) RefuseLossless();
    for (int i = 0; i < times; ++i) lengths[at++] = repeated;
  }
  return PrefixCode(used);
}

// The bits of the colour cache; 0 without one.
int TakeCacheBits(LosslessBits& bits) {
  if (bits.Take(1) == 0) return 0;
  const int cache = static_cast<int>(bits.Take(4));
  if (cache < 1 || cache > kMaxCacheBits) RefuseLossless();
  return cache;
}

int64_t TakeLength(LosslessBits& bits, int symbol) {
  if (symbol < 4) return symbol + 1;
  const int extra = (symbol - 2) >> 1;
  return ((2 + (symbol & 1)) << extra) + int64_t{bits.Take(extra)} + 1;
}

// Skips an image with one group of codes: a transform's data, or the map of the groups. Returns the
// largest 16-bit value of its pixels' red and green. All other pixels are copies.
int TakeImage(LosslessBits& bits, int64_t pixels) {
  const int cache = TakeCacheBits(bits);
  const PrefixCode green = TakeCode(bits, kLiterals + kLengths + (cache > 0 ? 1 << cache : 0));
  const PrefixCode red = TakeCode(bits, kLiterals);
  const PrefixCode blue = TakeCode(bits, kLiterals);
  const PrefixCode alpha = TakeCode(bits, kLiterals);
  const PrefixCode distance = TakeCode(bits, kDistances);
  int most = 0;
  for (int64_t at = 0; at < pixels;) {
    const int symbol = green.Take(bits);
    if (symbol < kLiterals) {
      most = std::max(most, red.Take(bits) << 8 | symbol);
      blue.Take(bits);
      alpha.Take(bits);
      ++at;
    } else if (symbol < kLiterals + kLengths) {
      at += TakeLength(bits, symbol - kLiterals);
      TakeLength(bits, distance.Take(bits));
    } else {
      ++at;
    }
  }
  return most;
}

int64_t Shrunk(int64_t size, int bits) { return (size + (int64_t{1} << bits) - 1) >> bits; }

}  // namespace

LosslessWebp ReadLosslessWebp(Bytes data) {
  constexpr uint32_t kSignature = 0x2F;
  LosslessBits bits(data);
  if (bits.Take(8) != kSignature) RefuseLossless();
  LosslessWebp image;
  image.width = static_cast<int>(bits.Take(14)) + 1;
  image.height = static_cast<int>(bits.Take(14)) + 1;
  bits.Take(1);  // whether alpha means anything
  if (bits.Take(3) != 0) RefuseLossless();
  int64_t columns = image.width;
  std::array<bool, 4> seen{};
  while (bits.Take(1) != 0) {
    const uint32_t transform = bits.Take(2);
    if (seen.at(transform)) RefuseLossless();
    seen.at(transform) = true;
    if (transform <= 1) {  // predictors, colours
      const int size = static_cast<int>(bits.Take(3)) + 2;
      TakeImage(bits, Shrunk(columns, size) * Shrunk(image.height, size));
    } else if (transform == 3) {  // a palette, whose indices share pixels when there are few
      const int colours = static_cast<int>(bits.Take(8)) + 1;
      TakeImage(bits, colours);
      columns = Shrunk(columns, colours > 16 ? 0 : colours > 4 ? 1 : colours > 2 ? 2 : 3);
    }
  }
  TakeCacheBits(bits);
  if (bits.Take(1) == 0) return image;
  const int size = static_cast<int>(bits.Take(3)) + 2;
  image.groups = 1 + TakeImage(bits, Shrunk(columns, size) * Shrunk(image.height, size));
  return image;
}

}  // namespace waystone
