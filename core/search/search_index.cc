// SPDX-License-Identifier: Apache-2.0
#include "core/search/search_index.h"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>
#include <span>

#include "core/base/check.h"

namespace waystone {
namespace {

// Blocks whose distances are taken at a time: they fit the first-level cache.
constexpr int kChunkBlocks = 16;
// The number of queries that choose their lists together, so that the centres are fetched once for
// all of them.
constexpr int kBatch = 32;

int BlocksFor(int rows) { return (rows + kPackRows - 1) / kPackRows; }

bool IsNearer(const Neighbour& a, const Neighbour& b) {
  return a.distance != b.distance ? a.distance < b.distance : a.row < b.row;
}

void InsertSorted(Neighbour* best, int k, Neighbour candidate) {
  int place = k - 1;
  while (place > 0 && IsNearer(candidate, best[place - 1])) {
    best[place] = best[place - 1];
    --place;
  }
  best[place] = candidate;
}

// Calls `visit(slot, distance)` for every slot of some blocks within `limit` of a query. The limit
// may fall meanwhile: slots beyond it may still be visited.
template <class Visit>
void ForEachNear(const PackedQuery& query, const PackedRows& rows, int first, int end,
                 const int32_t& limit, const Visit& visit) {
  std::array<int32_t, kChunkBlocks * kPackRows> distances;
  std::array<uint8_t, kChunkBlocks> near;
  for (int start = first; start < end; start += kChunkBlocks) {
    const int count = std::min(kChunkBlocks, end - start);
    PackedDistances(query, rows, start, count, limit, distances.data(), near.data());
    for (int b = 0; b < count; ++b) {
      if (near[b] == 0) continue;
      for (int i = 0; i < kPackRows; ++i) {
        const int32_t distance = distances[b * kPackRows + i];
        if (distance <= limit) visit((start + b) * kPackRows + i, distance);
      }
    }
  }
}

// The `count` slots with the smallest distances, ties by slot, in no order; empty ones aren't among
// them. By a histogram of the distances, so that only one bucket has to be sorted.
std::vector<int> NearestSlots(std::span<const int32_t> distances, int count) {
  constexpr int kBucketBits = 8;
  const auto is_empty = [](int32_t distance) { return distance >= kEmptySlotDistance; };
  int32_t low = kEmptySlotDistance;
  int32_t high = 0;
  for (const int32_t distance : distances) {
    low = std::min(low, distance);
    high = std::max(high, is_empty(distance) ? 0 : distance);
  }
  const int width = std::bit_width(static_cast<uint32_t>(std::max(0, high - low)));
  const int shift = std::max(0, width - kBucketBits);
  std::array<int, (1 << kBucketBits)> sizes{};
  for (const int32_t distance : distances) {
    if (!is_empty(distance)) ++sizes[(distance - low) >> shift];
  }
  int last = 0;  // the bucket that isn't taken whole
  int below = 0;
  while (last + 1 < std::ssize(sizes) && below + sizes[last] <= count) below += sizes[last++];
  std::vector<int> slots;
  slots.reserve(count + sizes[last]);
  std::vector<int> rest;
  for (int slot = 0; slot < std::ssize(distances); ++slot) {
    if (is_empty(distances[slot])) continue;
    const int bucket = (distances[slot] - low) >> shift;
    if (bucket < last) slots.push_back(slot);
    if (bucket == last) rest.push_back(slot);
  }
  const auto wanted = std::min<ptrdiff_t>(count - std::ssize(slots), std::ssize(rest));
  std::nth_element(rest.begin(), rest.begin() + wanted, rest.end(), [&](int a, int b) {
    return distances[a] != distances[b] ? distances[a] < distances[b] : a < b;
  });
  slots.insert(slots.end(), rest.begin(), rest.begin() + wanted);
  return slots;
}

}  // namespace

// Which queries search which list: those of list l are query[start[l]] to query[start[l + 1]].
struct SearchIndex::Visits {
  std::vector<int> start;
  std::vector<int> query;
};

SearchIndex::SearchIndex(FeatureType type, int rows)
    : SearchIndex(
          type, Descriptors(DescriptorBytes(type), std::vector<uint8_t>(DescriptorBytes(type), 0)),
          std::vector<uint16_t>(rows, 0)) {}

SearchIndex::SearchIndex(FeatureType type, const InvertedFile& file)
    : SearchIndex(type, file.centres, file.list_of_row) {}

SearchIndex::SearchIndex(FeatureType type, const Descriptors& centres,
                         const std::vector<uint16_t>& list_of_row)
    : type_(type), centres_(type, centres), slot_of_row_(list_of_row.size()) {
  std::vector<int> sizes(centres.rows(), 0);
  for (const uint16_t list : list_of_row) ++sizes[list];
  std::vector<int> next_slot;
  for (const int size : sizes) {
    next_slot.push_back(first_block_.back() * kPackRows);
    first_block_.push_back(first_block_.back() + BlocksFor(size));
  }
  row_of_slot_.assign(static_cast<size_t>(first_block_.back()) * kPackRows, -1);
  for (int row = 0; row < rows(); ++row) {
    const int slot = next_slot[list_of_row[row]]++;
    slot_of_row_[row] = slot;
    row_of_slot_[slot] = row;
  }
  rows_ = PackedRows(type, first_block_.back());
}

Descriptors SearchIndex::Rows(int first, int count) const {
  const int bytes = DescriptorBytes(type_);
  std::vector<uint8_t> data(static_cast<size_t>(count) * bytes);
  for (int i = 0; i < count; ++i) {
    rows_.CopyRow(slot_of_row_[first + i], data.data() + static_cast<size_t>(i) * bytes);
  }
  return {bytes, std::move(data)};
}

SearchIndex::Visits SearchIndex::ChooseLists(const std::vector<PackedQuery>& queries,
                                             int probes) const {
  const int count = static_cast<int>(queries.size());
  const int chosen = std::min(probes, lists());
  std::vector<int> list_of_visit;
  list_of_visit.reserve(static_cast<size_t>(count) * chosen);
  Visits visits{std::vector<int>(lists() + 1, 0), {}};
  const size_t slots = static_cast<size_t>(centres_.slots());
  std::vector<int32_t> distances(kBatch * slots);
  std::array<uint8_t, kChunkBlocks> near;
  for (int first = 0; first < count; first += kBatch) {
    const int batch = std::min(kBatch, count - first);
    for (int block = 0; block < centres_.blocks(); block += kChunkBlocks) {
      const int blocks = std::min(kChunkBlocks, centres_.blocks() - block);
      for (int q = 0; q < batch; ++q) {
        PackedDistances(queries[first + q], centres_, block, blocks, kEmptySlotDistance,
                        distances.data() + static_cast<size_t>(q) * slots + block * kPackRows,
                        near.data());
      }
    }
    for (int q = 0; q < batch; ++q) {
      for (const int list :
           NearestSlots({distances.data() + static_cast<size_t>(q) * slots, slots}, chosen)) {
        list_of_visit.push_back(list);
        ++visits.start[list + 1];
      }
    }
  }
  std::partial_sum(visits.start.begin(), visits.start.end(), visits.start.begin());
  std::vector<int> next(visits.start.begin(), visits.start.end() - 1);
  visits.query.resize(list_of_visit.size());
  for (size_t v = 0; v < list_of_visit.size(); ++v) {
    visits.query[next[list_of_visit[v]]++] = static_cast<int>(v) / chosen;
  }
  return visits;
}

void SearchIndex::SearchBlocks(int first, int end, const PackedQuery& query, int k,
                               Neighbour* best) const {
  int32_t limit = std::min(best[k - 1].distance, kEmptySlotDistance - 1);
  ForEachNear(query, rows_, first, end, limit, [&](int slot, int32_t distance) {
    const Neighbour candidate{row_of_slot_[slot], distance};
    if (!IsNearer(candidate, best[k - 1])) return;
    InsertSorted(best, k, candidate);
    limit = std::min(best[k - 1].distance, limit);
  });
}

std::vector<Neighbour> SearchIndex::Nearest(DescriptorsView queries, int k, int probes) const {
  WS_CHECK(k >= 1 && probes >= 1, "k and probes must be positive");
  std::vector<Neighbour> best(static_cast<size_t>(queries.rows()) * k);
  if (rows() == 0) return best;
  std::vector<PackedQuery> packed;
  packed.reserve(queries.rows());
  for (int q = 0; q < queries.rows(); ++q) packed.emplace_back(type_, queries.row(q));
  const Visits visits = ChooseLists(packed, probes);
  // Chunk by chunk rather than query by query: a chunk stays in the cache for all queries that
  // visit its list.
  for (int list = 0; list < lists(); ++list) {
    for (int start = first_block_[list]; start < first_block_[list + 1]; start += kChunkBlocks) {
      const int end = std::min(start + kChunkBlocks, first_block_[list + 1]);
      for (int v = visits.start[list]; v < visits.start[list + 1]; ++v) {
        const int query = visits.query[v];
        SearchBlocks(start, end, packed[query], k, best.data() + static_cast<size_t>(query) * k);
      }
    }
  }
  return best;
}

}  // namespace waystone
