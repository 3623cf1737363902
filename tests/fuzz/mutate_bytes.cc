// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/mutate_bytes.h"

#include <zlib.h>

#include <algorithm>
#include <array>

namespace waystone {
namespace {

constexpr std::array<int64_t, 14> kLimits{
    0, 1, -1, 127, 128, 255, 256, 32767, 32768, 65535, 100000, 1 << 30, 2147483647, 4294967295};

size_t Place(const std::string& bytes, Random& random) {
  return bytes.empty() ? 0 : random.Below(static_cast<int>(bytes.size()));
}

// A length up to `most`; mostly short.
size_t Length(size_t most, Random& random) {
  const int longest = static_cast<int>(std::min<size_t>(most, random.Below(4) == 0 ? most : 8));
  return longest == 0 ? 0 : 1 + random.Below(longest);
}

void PutNumber(std::string& bytes, Random& random) {
  const auto value = static_cast<uint64_t>(kLimits.at(random.Below(kLimits.size())));
  const int size = 1 << random.Below(4);
  const bool big = random.Below(2) == 0;
  const size_t at = Place(bytes, random);
  for (int i = 0; i < size && at + i < bytes.size(); ++i) {
    bytes[at + i] = static_cast<char>(value >> 8 * (big ? size - 1 - i : i));
  }
}

// The digits from a place on become another number.
void PutDigits(std::string& bytes, Random& random) {
  const size_t start = bytes.find_first_of("0123456789", Place(bytes, random));
  if (start == std::string::npos) return;
  const size_t end = std::min(bytes.find_first_not_of("0123456789", start), bytes.size());
  static const std::array<std::string, 8> kNumbers{
      "0", "-1", "65536", "2147483648", "9223372036854775808", "1e308", "1e-320", "nan"};
  bytes.replace(start, end - start, kNumbers.at(random.Below(kNumbers.size())));
}

void PutStretch(std::string& bytes, const std::string& from, Random& random) {
  const size_t start = Place(from, random);
  const std::string stretch = from.substr(start, Length(from.size() - start, random));
  const size_t at = Place(bytes, random);
  if (random.Below(2) == 0) {
    bytes.insert(at, stretch);
  } else {
    bytes.replace(at, stretch.size(), stretch);
  }
}

void ChangeOnce(std::string& bytes, const std::string& other, Random& random) {
  if (bytes.empty()) bytes = other.empty() ? "0" : other;
  const size_t at = Place(bytes, random);
  switch (random.Below(8)) {
    case 0:
      bytes[at] = static_cast<char>(bytes[at] ^ 1 << random.Below(8));
      break;
    case 1:
      bytes[at] = static_cast<char>(random.Below(256));
      break;
    case 2:
      bytes.erase(at, Length(bytes.size() - at, random));
      break;
    case 3:
      bytes.insert(at, Length(64, random), static_cast<char>(random.Below(256)));
      break;
    case 4:
      PutNumber(bytes, random);
      break;
    case 5:
      PutDigits(bytes, random);
      break;
    case 6:
      PutStretch(bytes, bytes, random);
      break;
    default:
      PutStretch(bytes, other, random);
  }
}

uint32_t BigEndianAt(const std::string& bytes, size_t at) {
  uint32_t value = 0;
  for (size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<uint8_t>(bytes[at + i]);
  return value;
}

void RepairPngChecksums(std::string& bytes) {
  constexpr size_t kSignatureSize = 8;
  constexpr size_t kAroundData = 12;
  if (!bytes.starts_with("\x89PNG")) return;
  for (size_t at = kSignatureSize; at + kAroundData <= bytes.size();) {
    const size_t length = BigEndianAt(bytes, at);
    if (length > bytes.size() - at - kAroundData) return;
    const auto* checked = reinterpret_cast<const Bytef*>(bytes.data() + at + 4);
    const uLong crc = crc32(0, checked, static_cast<uInt>(length + 4));
    for (int i = 0; i < 4; ++i) {
      bytes[at + 8 + length + i] = static_cast<char>(crc >> 8 * (3 - i));
    }
    at += kAroundData + length;
  }
}

}  // namespace

std::string MutateSimply(std::string bytes, const std::string& other, size_t max_bytes,
                         Random& random) {
  for (int i = 1 + random.Below(4); i > 0; --i) ChangeOnce(bytes, other, random);
  if (bytes.size() > max_bytes) bytes.resize(max_bytes);
  return bytes;
}

std::string MutateImage(std::string bytes, size_t max_bytes, uint32_t seed,
                        const MutateBytes& mutate) {
  bytes = mutate(std::move(bytes), max_bytes);
  if (seed % 4 != 0) RepairPngChecksums(bytes);
  return bytes;
}

}  // namespace waystone
