// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/features/match.h"
#include "core/features/packed_rows.h"
#include "core/search/inverted_file.h"

namespace waystone {

// Descriptors ready to be searched, each list of an inverted file contiguous in memory; the only
// copy of them that is needed. Filled once (Set every row), then immutable: any number of threads
// may search it.
class SearchIndex {
 public:
  SearchIndex() = default;
  // A single list: every search is exhaustive.
  SearchIndex(FeatureType type, int rows);
  // The lists of `file`, in which InvertedFileProblem must find nothing.
  SearchIndex(FeatureType type, const InvertedFile& file);

  void Set(int row, const uint8_t* descriptor) { rows_.Set(slot_of_row_[row], descriptor); }

  int rows() const { return static_cast<int>(slot_of_row_.size()); }
  int lists() const { return static_cast<int>(first_block_.size()) - 1; }
  // Rows `first` to `first + count`, as they were set.
  Descriptors Rows(int first, int count) const;

  // The k nearest rows of every query among the rows of the `probes` lists with the nearest centres
  // (all lists when there are no more): nearest first, ties by row, k per query, query after query;
  // missing ones have row -1. k and probes at least 1.
  std::vector<Neighbour> Nearest(DescriptorsView queries, int k, int probes) const;

 private:
  struct Visits;
  SearchIndex(FeatureType type, const Descriptors& centres,
              const std::vector<uint16_t>& list_of_row);
  Visits ChooseLists(const std::vector<PackedQuery>& queries, int probes) const;
  void SearchBlocks(int first, int end, const PackedQuery& query, int k, Neighbour* best) const;

  FeatureType type_ = FeatureType::kSift;
  PackedRows centres_;
  std::vector<int> first_block_ = {0};  // of each list, and one more for the end
  std::vector<int> slot_of_row_;
  std::vector<int> row_of_slot_;  // -1 for an empty slot
  PackedRows rows_;
};

}  // namespace waystone
