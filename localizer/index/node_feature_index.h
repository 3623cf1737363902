// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/search/search_index.h"
#include "schema/layers/appearance/appearance_layer.h"

namespace waystone {

// Few lists, learned from few rows: the index is made when it is first needed, once for all queries
// (so this isn't a query's option), and a ranking of nodes tolerates missed neighbours.
inline constexpr InvertedFileOptions kNodeFeatureLists{
    .lists_per_root = 1, .training_rows = 16, .rounds = 4};

// The features that an appearance layer's nodes keep, in one index: finds which nodes saw what a
// photo shows, without matching it with each. 128 bytes per feature (SIFT). Immutable after
// construction: any number of threads may query it. The same on any number of threads.
class NodeFeatureIndex {
 public:
  // Copies what it needs. `type` is the map's.
  NodeFeatureIndex(const AppearanceLayer& layer, FeatureType type,
                   const InvertedFileOptions& lists = kNodeFeatureLists);

  // The `count` nodes with the most votes, most first, ties by node; fewer where fewer have any.
  // Each query descriptor votes once for each node of its `neighbours` nearest features in the
  // `probes` lists nearest to it: the more, the nearer that feature is compared with the farthest
  // of them (Jegou, Douze and Schmid 2011, "Exploiting descriptor distances for precise image
  // search"). Nodes i with left_out[i] are skipped; an empty vector skips none.
  std::vector<int> MostVoted(DescriptorsView query, int count, int neighbours, int probes,
                             const std::vector<bool>& left_out = {}) const;

 private:
  int nodes_ = 0;
  SearchIndex search_;
  std::vector<int> node_of_row_;
};

}  // namespace waystone
