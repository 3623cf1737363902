// SPDX-License-Identifier: Apache-2.0
#include "core/features/descriptor_codes.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace waystone {
namespace {

constexpr int kBits = 2;
constexpr int kPerByte = 8 / kBits;
constexpr int kLevels = 1 << kBits;
constexpr double kLength = 256;  // of a descriptor
constexpr double kMaxEntry = 127;
// The value that each code stands for, and the entries at which the next code starts: the quantiser
// of least squared error for the entries of RootSIFT, in round numbers.
constexpr std::array<int, kLevels> kMeans = {2, 14, 27, 44};
constexpr std::array<int, kLevels - 1> kBounds = {8, 21, 36};

int CodeOf(uint8_t entry) {
  int code = 0;
  for (const int bound : kBounds) code += entry >= bound;
  return code;
}

}  // namespace

int CodeBytes(FeatureType type) {
  const int bytes = DescriptorBytes(type);
  return type == FeatureType::kSift ? bytes / kPerByte : bytes;
}

Descriptors EncodeDescriptors(DescriptorsView descriptors, FeatureType type) {
  Descriptors codes(CodeBytes(type));
  codes.Reserve(descriptors.rows());
  std::vector<uint8_t> code(CodeBytes(type));
  for (int row = 0; row < descriptors.rows(); ++row) {
    const uint8_t* entries = descriptors.row(row);
    if (type != FeatureType::kSift) {
      codes.Append(entries);
      continue;
    }
    for (size_t byte = 0; byte < code.size(); ++byte) {
      int bits = 0;
      for (int i = 0; i < kPerByte; ++i) bits |= CodeOf(entries[byte * kPerByte + i]) << kBits * i;
      code[byte] = static_cast<uint8_t>(bits);
    }
    codes.Append(code.data());
  }
  return codes;
}

Descriptors DecodeDescriptors(DescriptorsView codes, FeatureType type) {
  const int bytes = DescriptorBytes(type);
  Descriptors descriptors(bytes);
  descriptors.Reserve(codes.rows());
  std::vector<uint8_t> entries(bytes);
  for (int row = 0; row < codes.rows(); ++row) {
    const uint8_t* code = codes.row(row);
    if (type != FeatureType::kSift) {
      descriptors.Append(code);
      continue;
    }
    double square = 0;
    for (int i = 0; i < bytes; ++i) {
      const int mean = kMeans[code[i / kPerByte] >> kBits * (i % kPerByte) & (kLevels - 1)];
      entries[i] = static_cast<uint8_t>(mean);
      square += mean * mean;
    }
    const double scale = kLength / std::sqrt(square);
    for (uint8_t& entry : entries) {
      entry = static_cast<uint8_t>(std::min(std::floor(entry * scale), kMaxEntry));
    }
    descriptors.Append(entries.data());
  }
  return descriptors;
}

}  // namespace waystone
