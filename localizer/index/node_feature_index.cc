// SPDX-License-Identifier: Apache-2.0
#include "localizer/index/node_feature_index.h"

#include <algorithm>
#include <numeric>
#include <span>

#include "core/base/check.h"
#include "core/features/descriptor_codes.h"

namespace waystone {
namespace {

Descriptors DescriptorsOf(const AppearanceLayer& layer, FeatureType type) {
  Descriptors all(DescriptorBytes(type));
  for (const AppearanceNode& node : layer.nodes) {
    if (node.features.bearings.empty()) continue;
    const Descriptors rows = DecodeDescriptors(node.features.codes, type);
    for (int row = 0; row < rows.rows(); ++row) all.Append(rows.row(row));
  }
  return all;
}

SearchIndex BuildNodeIndex(const Descriptors& rows, FeatureType type,
                           const InvertedFileOptions& options) {
  const InvertedFile file = BuildInvertedFile(rows, type, options);
  SearchIndex search =
      file.list_of_row.empty() ? SearchIndex(type, rows.rows()) : SearchIndex(type, file);
  for (int row = 0; row < rows.rows(); ++row) search.Set(row, rows.row(row));
  return search;
}

}  // namespace

NodeFeatureIndex::NodeFeatureIndex(const AppearanceLayer& layer, FeatureType type,
                                   const InvertedFileOptions& lists)
    : nodes_(static_cast<int>(layer.nodes.size())) {
  lists.Check();
  search_ = BuildNodeIndex(DescriptorsOf(layer, type), type, lists);
  for (int node = 0; node < nodes_; ++node) {
    node_of_row_.insert(node_of_row_.end(), layer.nodes[node].features.bearings.size(), node);
  }
  WS_CHECK(std::ssize(node_of_row_) == search_.rows(), "a descriptor a feature");
}

std::vector<int> NodeFeatureIndex::MostVoted(DescriptorsView query, int count, int neighbours,
                                             int probes, const std::vector<bool>& left_out) const {
  WS_CHECK(count > 0 && neighbours > 0, "at least one node and one neighbour must be asked for");
  WS_CHECK(left_out.empty() || left_out.size() == static_cast<size_t>(nodes_), "one flag a node");
  const std::vector<Neighbour> nearest = search_.Nearest(query, neighbours, probes);
  std::vector<double> votes(nodes_, 0);
  std::vector<int> last_voter(nodes_, -1);
  for (int row = 0; row < query.rows(); ++row) {
    const std::span<const Neighbour> of_row(nearest.data() + static_cast<size_t>(row) * neighbours,
                                            neighbours);
    // Where the lists have fewer neighbours, the farthest one found.
    int last = neighbours - 1;
    while (last > 0 && of_row[last].row < 0) --last;
    for (const Neighbour& near : of_row.first(last)) {
      const int node = node_of_row_[near.row];
      if (last_voter[node] == row || (!left_out.empty() && left_out[node])) continue;
      last_voter[node] = row;
      votes[node] += 1 - static_cast<double>(near.distance) / std::max(of_row[last].distance, 1);
    }
  }
  std::vector<int> nodes(nodes_);
  std::iota(nodes.begin(), nodes.end(), 0);
  std::erase_if(nodes, [&](int node) { return votes[node] <= 0; });
  std::ranges::stable_sort(nodes, std::ranges::greater{}, [&](int node) { return votes[node]; });
  nodes.resize(std::min(nodes.size(), static_cast<size_t>(count)));
  return nodes;
}

}  // namespace waystone
