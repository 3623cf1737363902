// SPDX-License-Identifier: Apache-2.0
#include "core/search/inverted_file.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/features/packed_rows.h"

namespace waystone {
namespace {

constexpr int kMaxLists = 1 << 15;
// Blocks of centres whose distances are taken at a time.
constexpr int kCentreBlocks = 32;

// The nearest centre of a row; the lower one in case of a tie.
int NearestCentre(const PackedRows& centres, const uint8_t* row) {
  const PackedQuery query(centres.type(), row);
  std::array<int32_t, kCentreBlocks * kPackRows> distances;
  std::array<uint8_t, kCentreBlocks> near;
  int32_t best = kEmptySlotDistance;
  int nearest = 0;
  for (int start = 0; start < centres.blocks(); start += kCentreBlocks) {
    const int count = std::min(kCentreBlocks, centres.blocks() - start);
    PackedDistances(query, centres, start, count, best - 1, distances.data(), near.data());
    for (int b = 0; b < count; ++b) {
      if (near[b] == 0) continue;
      for (int i = b * kPackRows; i < (b + 1) * kPackRows; ++i) {
        if (distances[i] >= best) continue;
        best = distances[i];
        nearest = start * kPackRows + i;
      }
    }
  }
  return nearest;
}

std::vector<uint16_t> Assign(const Descriptors& centres, FeatureType type, DescriptorsView rows) {
  const PackedRows packed(type, centres);
  std::vector<uint16_t> lists(rows.rows());
  tbb::parallel_for(tbb::blocked_range<int>(0, rows.rows(), 256), [&](const auto& range) {
    for (int i = range.begin(); i != range.end(); ++i) {
      lists[i] = static_cast<uint16_t>(NearestCentre(packed, rows.row(i)));
    }
  });
  return lists;
}

// `count` different rows in a random order: the first steps of a Fisher-Yates shuffle.
Descriptors Sample(DescriptorsView rows, int count, Random& random) {
  std::vector<int> order(rows.rows());
  std::iota(order.begin(), order.end(), 0);
  Descriptors sample(rows.bytes);
  sample.Reserve(count);
  for (int i = 0; i < count; ++i) {
    std::swap(order[i], order[i + random.Below(rows.rows() - i)]);
    sample.Append(rows.row(order[i]));
  }
  return sample;
}

// Rows sorted by their list: those of list l are order[start[l]] to order[start[l + 1]].
struct Grouped {
  std::vector<int> start;
  std::vector<int> order;
};

Grouped GroupByList(const std::vector<uint16_t>& lists, int list_count) {
  Grouped grouped{std::vector<int>(list_count + 1, 0), std::vector<int>(lists.size())};
  for (const uint16_t list : lists) ++grouped.start[list + 1];
  std::partial_sum(grouped.start.begin(), grouped.start.end(), grouped.start.begin());
  std::vector<int> next(grouped.start.begin(), grouped.start.end() - 1);
  for (int i = 0; i < static_cast<int>(lists.size()); ++i) grouped.order[next[lists[i]]++] = i;
  return grouped;
}

// Mean of the members, rounded.
void ComputeMean(const Descriptors& rows, std::span<const int> members, uint8_t* centre) {
  std::vector<int64_t> sums(rows.bytes(), 0);
  for (const int member : members) {
    const uint8_t* row = rows.row(member);
    for (int i = 0; i < rows.bytes(); ++i) sums[i] += row[i];
  }
  const auto count = static_cast<int64_t>(members.size());
  for (int i = 0; i < rows.bytes(); ++i) {
    centre[i] = static_cast<uint8_t>((2 * sums[i] + count) / (2 * count));
  }
}

// The majority of the members for each bit (k-majority, which is k-means for Hamming distances).
void ComputeMajority(const Descriptors& rows, std::span<const int> members, uint8_t* centre) {
  std::vector<size_t> ones(static_cast<size_t>(rows.bytes()) * 8, 0);
  for (const int member : members) {
    const uint8_t* row = rows.row(member);
    for (size_t bit = 0; bit < ones.size(); ++bit) ones[bit] += (row[bit / 8] >> (bit % 8)) & 1;
  }
  std::fill_n(centre, rows.bytes(), uint8_t{0});
  for (size_t bit = 0; bit < ones.size(); ++bit) {
    if (2 * ones[bit] > members.size()) centre[bit / 8] |= static_cast<uint8_t>(1 << (bit % 8));
  }
}

// Centres of the lists that `lists` sorts the rows into. A list that has lost all its rows restarts
// from one drawn at random.
Descriptors LearnCentres(const Descriptors& rows, FeatureType type, int list_count,
                         const std::vector<uint16_t>& lists, Random& random) {
  const Grouped grouped = GroupByList(lists, list_count);
  std::vector<uint8_t> data(static_cast<size_t>(list_count) * rows.bytes());
  for (int list = 0; list < list_count; ++list) {
    uint8_t* centre = data.data() + static_cast<size_t>(list) * rows.bytes();
    const std::span<const int> members(grouped.order.data() + grouped.start[list],
                                       grouped.order.data() + grouped.start[list + 1]);
    if (members.empty()) {
      std::copy_n(rows.row(random.Below(rows.rows())), rows.bytes(), centre);
    } else if (type == FeatureType::kSift) {
      ComputeMean(rows, members, centre);
    } else {
      ComputeMajority(rows, members, centre);
    }
  }
  return {rows.bytes(), std::move(data)};
}

}  // namespace

void InvertedFileOptions::Check() const { CheckFields("index", *this); }

int ListCount(int64_t rows, const InvertedFileOptions& options) {
  if (rows < options.min_rows) return 0;
  const double wanted = options.lists_per_root * std::sqrt(static_cast<double>(rows));
  const int lists = 1 << std::clamp(static_cast<int>(std::lround(std::log2(wanted))), 0, 15);
  return static_cast<int>(std::min<int64_t>({lists, kMaxLists, rows}));
}

InvertedFile BuildInvertedFile(DescriptorsView rows, FeatureType type,
                               const InvertedFileOptions& options) {
  options.Check();
  WS_CHECK(rows.rows() == 0 || rows.bytes == DescriptorBytes(type), "descriptors of another type");
  InvertedFile file{Descriptors(DescriptorBytes(type)), {}};
  const int list_count = ListCount(rows.rows(), options);
  if (list_count == 0) return file;
  Random random(options.seed);
  const int64_t wanted = static_cast<int64_t>(options.training_rows) * list_count;
  const Descriptors sample =
      Sample(rows, static_cast<int>(std::min<int64_t>(wanted, rows.rows())), random);
  const auto first = sample.data().begin();
  file.centres =
      Descriptors(rows.bytes, {first, first + static_cast<ptrdiff_t>(list_count) * rows.bytes});
  for (int round = 0; round < options.rounds; ++round) {
    const std::vector<uint16_t> lists = Assign(file.centres, type, sample);
    file.centres = LearnCentres(sample, type, list_count, lists, random);
  }
  file.list_of_row = Assign(file.centres, type, rows);
  return file;
}

std::string InvertedFileProblem(const InvertedFile& file, int64_t rows, FeatureType type) {
  const int lists = file.centres.rows();
  if (lists < 1 || lists > kMaxLists) {
    return std::to_string(lists) + " lists; 1 to " + std::to_string(kMaxLists) + " are valid";
  }
  if (file.centres.bytes() != DescriptorBytes(type)) {
    return "centres of " + std::to_string(file.centres.bytes()) + " bytes; " +
           std::string(NameOf(type)) + " has " + std::to_string(DescriptorBytes(type));
  }
  if (std::ssize(file.list_of_row) != rows) {
    return std::to_string(file.list_of_row.size()) + " rows; the planes have " +
           std::to_string(rows) + " features";
  }
  for (size_t i = 0; i < file.list_of_row.size(); ++i) {
    if (file.list_of_row[i] < lists) continue;
    return "row " + std::to_string(i) + " is in list " + std::to_string(file.list_of_row[i]) +
           " of " + std::to_string(lists);
  }
  return "";
}

}  // namespace waystone
