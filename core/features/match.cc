// SPDX-License-Identifier: Apache-2.0
#include "core/features/match.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace waystone {
namespace {

// Blocks of rows whose distances are taken at a time: they fit the first-level cache.
constexpr int kChunk = 16;

// For each row of a: the two nearest of b so far.
struct NearestTwo {
  explicit NearestTwo(int slots) : first(slots, kNone), second(slots, kNone), row(slots, -1) {}

  static constexpr int32_t kNone = std::numeric_limits<int32_t>::max();
  std::vector<int32_t> first;  // distances
  std::vector<int32_t> second;
  std::vector<int32_t> row;  // of the first
};

// Updates every slot of a with its distance to row `row` of b. Returns the smallest of them. Free
// of branches and inlined into a function per instruction set, so that the compiler can vectorise
// it.
inline __attribute__((always_inline)) int32_t OfferRow(const int32_t* __restrict distances,
                                                       int slots, int32_t row,
                                                       int32_t* __restrict first,
                                                       int32_t* __restrict second,
                                                       int32_t* __restrict nearest) {
  int32_t least = NearestTwo::kNone;
  for (int i = 0; i < slots; ++i) {
    const int32_t d = distances[i];
    nearest[i] = d < first[i] ? row : nearest[i];
    second[i] = std::min(second[i], std::max(first[i], d));
    first[i] = std::min(first[i], d);
    least = std::min(least, d);
  }
  return least;
}

using OfferFunction = int32_t (*)(const int32_t*, int, int32_t, int32_t*, int32_t*, int32_t*);

int32_t OfferPortable(const int32_t* distances, int slots, int32_t row, int32_t* first,
                      int32_t* second, int32_t* nearest) {
  return OfferRow(distances, slots, row, first, second, nearest);
}

#if defined(__x86_64__)
__attribute__((target("avx2"))) int32_t OfferAvx2(const int32_t* distances, int slots, int32_t row,
                                                  int32_t* first, int32_t* second,
                                                  int32_t* nearest) {
  return OfferRow(distances, slots, row, first, second, nearest);
}
#endif

OfferFunction FastestOffer() {
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2")) return OfferAvx2;
#endif
  return OfferPortable;
}

}  // namespace

void MatchOptions::Check() const { CheckFields("match", *this); }

double DistanceRatio(FeatureType type, int nearer, int farther) {
  const double ratio = static_cast<double>(nearer) / farther;
  return type == FeatureType::kSift ? std::sqrt(ratio) : ratio;
}

bool PassesRatio(FeatureType type, int nearest, int second, double max_ratio) {
  const double limit = type == FeatureType::kSift ? max_ratio * max_ratio : max_ratio;
  return nearest < limit * second;
}

std::vector<Match> MatchDescriptors(DescriptorsView a, DescriptorsView b, FeatureType type,
                                    const MatchOptions& options) {
  return MatchDescriptors(PackedRows(type, a), a.rows(), b, options);
}

std::vector<Match> MatchDescriptors(const PackedRows& a, int a_rows, DescriptorsView b,
                                    const MatchOptions& options) {
  options.Check();
  static const OfferFunction offer = FastestOffer();
  std::vector<PackedQuery> rows;
  rows.reserve(b.rows());
  for (int row = 0; row < b.rows(); ++row) rows.emplace_back(a.type(), b.row(row));
  NearestTwo of_a(a.slots());
  std::vector<Neighbour> of_b(b.rows());
  std::array<int32_t, kChunk * kPackRows> distances;
  std::array<uint8_t, kChunk> near;
  for (int block = 0; block < a.blocks(); block += kChunk) {
    const int blocks = std::min(kChunk, a.blocks() - block);
    const int first = block * kPackRows;
    for (int row = 0; row < b.rows(); ++row) {
      PackedDistances(rows[row], a, block, blocks, 0, distances.data(), near.data());
      const int32_t least =
          offer(distances.data(), blocks * kPackRows, row, of_a.first.data() + first,
                of_a.second.data() + first, of_a.row.data() + first);
      if (least >= of_b[row].distance) continue;
      const auto place = std::find(distances.begin(), distances.end(), least);
      of_b[row] = {first + static_cast<int>(place - distances.begin()), least};
    }
  }
  std::vector<Match> matches;
  for (int i = 0; i < a_rows; ++i) {
    const int row = of_a.row[i];
    if (row < 0) continue;
    if (!PassesRatio(a.type(), of_a.first[i], of_a.second[i], options.max_ratio)) continue;
    if (options.mutual && of_b[row].row != i) continue;
    matches.push_back({i, row, of_a.first[i]});
  }
  return matches;
}

}  // namespace waystone
