// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/features/packed_rows.h"

namespace waystone {

// A descriptor in 10 bytes: its word, and what distinguishes it from others of that word (Hamming
// embedding: Jegou, Douze and Schmid, ECCV 2008).
struct WordCode {
  uint16_t word = 0;
  uint64_t signature = 0;

  bool operator==(const WordCode&) const = default;
};

// Bits in which two descriptors of one word differ: 0 to 64, about 32 for unrelated ones.
inline int SignatureDistance(uint64_t a, uint64_t b) { return std::popcount(a ^ b); }

// Words that don't depend on any map, so that codes of all maps, programs and times are comparable.
// A descriptor is cut into halves, each of which is assigned to one of 256 prototypes: a pair of
// these is a word (Babenko and Lempitsky, The inverted multi-index, CVPR 2012). The prototypes were
// learned on rendered buildings (`waystone-bench collection --learn`) and are frozen: changing them
// would invalidate all stored codes. Immutable; thread-safe. All results are integers, the same on
// every machine.
class Vocabulary {
 public:
  static constexpr int kPrototypes = 256;  // of each half
  static constexpr int kCount = kPrototypes * kPrototypes;

  // The built-in vocabulary of a feature type.
  static const Vocabulary& Of(FeatureType type);
  // From prototypes: a row of both halves each, kPrototypes rows (WS_CHECK).
  Vocabulary(FeatureType type, const Descriptors& prototypes);

  // The nearest word of a descriptor, and its signature there.
  WordCode Encode(const uint8_t* descriptor) const;
  // The `count` nearest words, at most kMaxProbes, nearest first, each with the descriptor's
  // signature there.
  std::vector<WordCode> Probe(const uint8_t* descriptor, int count) const;

  static constexpr int kMaxProbes = 32;
  // Bytes of a descriptor that belong to its first half.
  static int FirstHalf(FeatureType type);

 private:
  static constexpr int kSigned = 64;
  using Projection = std::array<int32_t, kSigned>;

  Projection Project(const uint8_t* descriptor, int from, int to) const;
  uint64_t Sign(const uint8_t* descriptor, const Projection& projected, int word) const;

  FeatureType type_;
  std::array<PackedRows, 2> prototypes_;              // the other half's bytes are zero
  std::array<std::vector<Projection>, 2> projected_;  // SIFT: of each prototype
  std::vector<int8_t> signs_;                         // SIFT: +-1, kSigned rows of the bytes
};

// The prototypes of a type as stored in words.bin, for learning or checking them. Thread-safe.
Descriptors WordPrototypes(FeatureType type);

}  // namespace waystone
