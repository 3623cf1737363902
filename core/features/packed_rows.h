// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/features/features.h"

namespace waystone {

// Rows of a block: eight words of four bytes fill one AVX2 register.
inline constexpr int kPackRows = 8;
// A slot without a row is at least this far from every query.
inline constexpr int32_t kEmptySlotDistance = 1 << 28;

// One descriptor as the kernels below need it: padded with zeros to whole words.
struct PackedQuery {
  PackedQuery(FeatureType type, const uint8_t* row);

  std::array<uint32_t, 32> words{};
  int32_t square = 0;   // SIFT: squared length
  bool narrow = false;  // see PackedRows::narrow
};

// Descriptors laid out for taking many distances at a time. A block holds kPackRows rows with their
// words of four bytes interleaved (word 0 of each row, then word 1 of each, ...), so that a lane of
// a register is a row and nothing has to be summed across lanes. Slots that were never set are
// empty. Thread-safe for reading; not while it is being filled.
class PackedRows {
 public:
  PackedRows() = default;
  PackedRows(FeatureType type, int blocks);
  explicit PackedRows(FeatureType type, DescriptorsView rows);

  void Set(int slot, const uint8_t* row);
  // Copies a row back, DescriptorBytes(type) bytes.
  void CopyRow(int slot, uint8_t* out) const;

  FeatureType type() const { return type_; }
  int blocks() const { return blocks_; }
  int slots() const { return blocks_ * kPackRows; }
  // SIFT: whether the sums of both halves of each word's products fit 16 bits, by Cauchy and
  // Schwarz; true of everything that ExtractFeatures gives, which has length 256.
  bool narrow() const { return narrow_; }
  int words() const { return words_; }
  const uint8_t* block(int i) const {
    return Data() + static_cast<size_t>(i) * words_ * 4 * kPackRows;
  }
  const int32_t* bias(int i) const { return bias_.data() + static_cast<size_t>(i) * kPackRows; }

 private:
  // A cache line: loads that cross from one line to the next take twice as long.
  struct alignas(64) Line {
    uint8_t bytes[64];
  };

  uint8_t* Data() { return reinterpret_cast<uint8_t*>(data_.data()); }
  const uint8_t* Data() const { return reinterpret_cast<const uint8_t*>(data_.data()); }

  FeatureType type_ = FeatureType::kSift;
  int words_ = 0;
  int blocks_ = 0;
  bool narrow_ = true;
  std::vector<Line> data_;
  std::vector<int32_t> bias_;  // of each slot: SIFT, the squared length; or kEmptySlotDistance
};

// Distances (in the unit of distance.h, exactly the same numbers; SIFT bytes above 127, which a map
// of another program may have, count as 127) of a query to the slots of `count` blocks from `first`
// on: out[8 * b + i], and bit i of near[b] for a distance of at most `limit`. Thread-safe.
void PackedDistances(const PackedQuery& query, const PackedRows& rows, int first, int count,
                     int32_t limit, int32_t* out, uint8_t* near);

// PackedDistances in every implementation that this processor can run, the portable one first: for
// tests and benchmarks.
using PackedDistancesFunction = void (*)(const PackedQuery&, const PackedRows&, int first,
                                         int count, int32_t limit, int32_t* out, uint8_t* near);
struct NamedPackedDistances {
  const char* name;
  PackedDistancesFunction function;
};
std::vector<NamedPackedDistances> RunnablePackedDistances();

}  // namespace waystone
