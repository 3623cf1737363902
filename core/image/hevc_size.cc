// SPDX-License-Identifier: Apache-2.0
#include "core/image/hevc_size.h"

#include <algorithm>
#include <vector>

namespace waystone {
namespace {

constexpr size_t kUnitHead = 2;

// Bits of a unit, without the emulation prevention bytes (3) after two zeros.
class HevcBits {
 public:
  explicit HevcBits(Bytes unit) {
    constexpr size_t kRead = 256;  // more than is ever read here
    int zeros = 0;
    const Bytes read = unit.first(std::min(unit.size(), kRead));
    for (const uint8_t byte : read.subspan(std::min(read.size(), kUnitHead))) {
      if (zeros >= 2 && byte == 3) {
        zeros = 0;
        continue;
      }
      zeros = byte == 0 ? zeros + 1 : 0;
      bytes_.push_back(byte);
    }
  }

  uint32_t Take(int count) {
    uint32_t value = 0;
    for (int i = 0; i < count; ++i) {
      if (at_ >= 8 * bytes_.size()) {
        RefuseImage("a parameter set of the HEIC is too short; it is damaged");
      }
      value = value << 1 | (bytes_[at_ / 8] >> (7 - at_ % 8) & 1);
      ++at_;
    }
    return value;
  }
  void Skip(int count) {
    for (; count > 0; --count) Take(1);
  }
  // An Exp-Golomb number.
  uint32_t TakeGolomb() {
    int zeros = 0;
    while (Take(1) == 0) {
      if (++zeros > 31) RefuseImage("a number in a parameter set of the HEIC is damaged");
    }
    return (uint32_t{1} << zeros) - 1 + Take(zeros);
  }

 private:
  std::vector<uint8_t> bytes_;
  size_t at_ = 0;
};

// profile_tier_level( 1, layers ), 7.3.3.
void SkipProfiles(HevcBits& bits, int layers) {
  constexpr int kProfile = 88;
  constexpr int kLevel = 8;
  bits.Skip(kProfile + kLevel);
  std::vector<uint32_t> present(2 * layers);
  for (uint32_t& each : present) each = bits.Take(1);
  if (layers > 0) bits.Skip(2 * (8 - layers));
  for (int i = 0; i < layers; ++i) {
    bits.Skip(present[2 * i] != 0 ? kProfile : 0);
    bits.Skip(present[2 * i + 1] != 0 ? kLevel : 0);
  }
}

}  // namespace

int HevcUnitType(Bytes unit) {
  if (unit.size() < kUnitHead) return -1;
  const int layer = (unit[0] & 1) << 5 | unit[1] >> 3;
  return layer == 0 ? unit[0] >> 1 & 0x3F : -1;
}

// seq_parameter_set_rbsp, 7.3.2.2.1, as far as the depth of its samples.
HevcSize ReadHevcSize(Bytes unit) {
  HevcBits bits(unit);
  bits.Skip(4);
  const int layers = static_cast<int>(bits.Take(3));
  bits.Skip(1);
  SkipProfiles(bits, layers);
  bits.TakeGolomb();  // its number
  const uint32_t chroma = bits.TakeGolomb();
  const bool separate = chroma == 3 && bits.Take(1) != 0;
  int64_t width = bits.TakeGolomb();
  int64_t height = bits.TakeGolomb();
  const int64_t coded_width = width;
  const int64_t coded_height = height;
  if (bits.Take(1) != 0) {
    const int64_t unit_x = chroma == 1 || chroma == 2 ? 2 : 1;
    const int64_t unit_y = chroma == 1 ? 2 : 1;
    width -= unit_x * bits.TakeGolomb();
    width -= unit_x * bits.TakeGolomb();
    height -= unit_y * bits.TakeGolomb();
    height -= unit_y * bits.TakeGolomb();
  }
  const uint32_t deeper = std::max(bits.TakeGolomb(), bits.TakeGolomb());
  constexpr int kMaxSide = 1 << 16;
  if (chroma > 3 || separate || deeper > 8 || width < 1 || height < 1 || coded_width > kMaxSide ||
      coded_height > kMaxSide) {
    RefuseImage("the HEIC claims pictures of " + std::to_string(width) + "x" +
                std::to_string(height) + " pixels with chroma format " + std::to_string(chroma) +
                " and " + std::to_string(deeper + 8) + " bits; it is damaged");
  }
  // Pictures are coded in blocks of at most 64 px, which the last one may exceed. What more is cut
  // off would be decoded for nothing.
  constexpr int kBlock = 64;
  if (coded_width - width >= kBlock || coded_height - height >= kBlock) {
    RefuseImage("the HEIC shows " + std::to_string(width) + "x" + std::to_string(height) +
                " pixels of pictures of " + std::to_string(coded_width) + "x" +
                std::to_string(coded_height) + "; it is damaged");
  }
  return {static_cast<int>(width), static_cast<int>(height), static_cast<int>(chroma),
          static_cast<int>(deeper) + 8, coded_width * coded_height};
}

}  // namespace waystone
