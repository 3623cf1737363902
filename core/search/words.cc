// SPDX-License-Identifier: Apache-2.0
#include "core/search/words.h"

#include <algorithm>
#include <utility>

#include "core/base/check.h"
#include "core/base/random.h"
#include "core/search/words_data.h"

namespace waystone {
namespace {

// Drawn once and frozen with the prototypes.
constexpr uint64_t kSignSeed = 20240917;

struct NearPrototype {
  int32_t distance = 0;
  int prototype = 0;
};

// The half of a descriptor with zeros for the other one.
std::array<uint8_t, 128> HalfOf(FeatureType type, const uint8_t* descriptor, int half) {
  std::array<uint8_t, 128> row{};
  const int cut = Vocabulary::FirstHalf(type);
  const int from = half == 0 ? 0 : cut;
  const int to = half == 0 ? cut : DescriptorBytes(type);
  std::copy(descriptor + from, descriptor + to, row.begin() + from);
  return row;
}

// The nearest prototypes of a half, nearest first, ties by number.
std::vector<NearPrototype> NearestOf(FeatureType type, const PackedRows& prototypes,
                                     const uint8_t* descriptor, int half, int count) {
  const std::array<uint8_t, 128> row = HalfOf(type, descriptor, half);
  std::array<int32_t, Vocabulary::kPrototypes> distances{};
  std::array<uint8_t, Vocabulary::kPrototypes / kPackRows> near{};
  PackedDistances(PackedQuery(type, row.data()), prototypes, 0, prototypes.blocks(),
                  kEmptySlotDistance, distances.data(), near.data());
  std::vector<NearPrototype> best(Vocabulary::kPrototypes);
  for (int i = 0; i < Vocabulary::kPrototypes; ++i) best[i] = {distances[i], i};
  const auto nearer = [](const NearPrototype& a, const NearPrototype& b) {
    return std::pair(a.distance, a.prototype) < std::pair(b.distance, b.prototype);
  };
  std::ranges::partial_sort(best, best.begin() + count, nearer);
  best.resize(count);
  return best;
}

}  // namespace

int Vocabulary::FirstHalf(FeatureType type) { return (DescriptorBytes(type) + 1) / 2; }

const Vocabulary& Vocabulary::Of(FeatureType type) {
  static const std::array<Vocabulary, 3> all{
      Vocabulary(FeatureType::kSift, WordPrototypes(FeatureType::kSift)),
      Vocabulary(FeatureType::kOrb, WordPrototypes(FeatureType::kOrb)),
      Vocabulary(FeatureType::kAkaze, WordPrototypes(FeatureType::kAkaze))};
  return all[static_cast<size_t>(type)];
}

Descriptors WordPrototypes(FeatureType type) {
  size_t start = 0;
  for (const FeatureType before : {FeatureType::kSift, FeatureType::kOrb}) {
    if (before < type)
      start += static_cast<size_t>(Vocabulary::kPrototypes) * DescriptorBytes(before);
  }
  const size_t bytes = static_cast<size_t>(Vocabulary::kPrototypes) * DescriptorBytes(type);
  WS_CHECK(start + bytes <= kWordsData.size(), "words.bin is too short");
  const auto first = kWordsData.begin() + static_cast<ptrdiff_t>(start);
  return {DescriptorBytes(type), {first, first + static_cast<ptrdiff_t>(bytes)}};
}

Vocabulary::Vocabulary(FeatureType type, const Descriptors& prototypes) : type_(type) {
  WS_CHECK(prototypes.rows() == kPrototypes && prototypes.bytes() == DescriptorBytes(type),
           "prototypes of another size");
  const int bytes = DescriptorBytes(type);
  if (type == FeatureType::kSift) {
    Random random(kSignSeed);
    for (int i = 0; i < kSigned * bytes; ++i) signs_.push_back(random.Below(2) == 0 ? -1 : 1);
  }
  for (int half = 0; half < 2; ++half) {
    prototypes_[half] = PackedRows(type, kPrototypes / kPackRows);
    for (int i = 0; i < kPrototypes; ++i) {
      const std::array<uint8_t, 128> row = HalfOf(type, prototypes.row(i), half);
      prototypes_[half].Set(i, row.data());
      if (type == FeatureType::kSift) projected_[half].push_back(Project(row.data(), 0, bytes));
    }
  }
}

Vocabulary::Projection Vocabulary::Project(const uint8_t* descriptor, int from, int to) const {
  Projection projected{};
  const int bytes = DescriptorBytes(type_);
  for (int row = 0; row < kSigned; ++row) {
    const int8_t* signs = signs_.data() + static_cast<size_t>(row) * bytes;
    int32_t sum = 0;
    for (int i = from; i < to; ++i) sum += signs[i] * descriptor[i];
    projected[row] = sum;
  }
  return projected;
}

// SIFT: on which side of its word a descriptor lies, in each of 64 directions. Binary ones: 64 of
// their bits, spread evenly.
uint64_t Vocabulary::Sign(const uint8_t* descriptor, const Projection& projected, int word) const {
  uint64_t signature = 0;
  if (type_ == FeatureType::kSift) {
    const Projection& a = projected_[0][word / kPrototypes];
    const Projection& b = projected_[1][word % kPrototypes];
    for (int i = 0; i < kSigned; ++i) {
      signature |= static_cast<uint64_t>(projected[i] > a[i] + b[i]) << i;
    }
    return signature;
  }
  const int bits = 8 * DescriptorBytes(type_);
  for (int i = 0; i < kSigned; ++i) {
    const int bit = i * bits / kSigned;
    signature |= static_cast<uint64_t>((descriptor[bit / 8] >> (bit % 8)) & 1) << i;
  }
  return signature;
}

WordCode Vocabulary::Encode(const uint8_t* descriptor) const {
  return Probe(descriptor, 1).front();
}

std::vector<WordCode> Vocabulary::Probe(const uint8_t* descriptor, int count) const {
  WS_CHECK(count >= 1 && count <= kMaxProbes, "too many words to probe");
  // In the nearest `count` pairs, each half is among its own nearest `count`.
  const std::vector<NearPrototype> a =
      NearestOf(type_, prototypes_[0], descriptor, 0, std::min(count, kPrototypes));
  const std::vector<NearPrototype> b =
      NearestOf(type_, prototypes_[1], descriptor, 1, std::min(count, kPrototypes));
  std::vector<std::pair<int32_t, int>> pairs;
  for (int i = 0; i < count; ++i) {
    // Pairs before it in both orders are at least as near.
    for (int j = 0; (i + 1) * (j + 1) <= count; ++j) {
      pairs.emplace_back(a[i].distance + b[j].distance,
                         a[i].prototype * kPrototypes + b[j].prototype);
    }
  }
  std::ranges::partial_sort(pairs, pairs.begin() + count);
  Projection projected{};
  if (type_ == FeatureType::kSift) projected = Project(descriptor, 0, DescriptorBytes(type_));
  std::vector<WordCode> words;
  words.reserve(count);
  for (int i = 0; i < count; ++i) {
    const int word = pairs[i].second;
    words.push_back({static_cast<uint16_t>(word), Sign(descriptor, projected, word)});
  }
  return words;
}

}  // namespace waystone
