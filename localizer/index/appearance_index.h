// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/options.h"
#include "core/panorama/fourier_signature.h"
#include "localizer/index/node_distances.h"
#include "schema/layers/appearance/appearance_layer.h"

namespace waystone {

// A node of the layer and how much its signature differs.
struct NearNode {
  int node = -1;        // index in the layer's nodes
  double distance = 0;  // of the signatures: 0 the same, about 1 for two random places of the map

  bool operator==(const NearNode&) const = default;
};

struct AppearanceIndexOptions {
  int frequencies = 16;
  int stride = 4;
  int typical_pairs = 2000;
  double alike = 0.5;
  int reach_nodes = 200;

  static constexpr auto Fields(const auto& use) {
    using Self = AppearanceIndexOptions;
    return use(
        OptionField{
            "frequencies", &Self::frequencies, Closed(1, 4096), "",
            "Number of magnitudes per row that are compared, from frequency 0, at most those of "
            "the layer. More magnitudes distinguish neighbours; fewer tolerate more motion."},
        OptionField{
            "stride", &Self::stride, Closed(1, 4096), "",
            "Number of frequencies summed between two tests of whether a node is already farther "
            "away than the best ones. Lower values stop sooner, but test more often."},
        OptionField{"typical_pairs", &Self::typical_pairs, Closed(1, 1'000'000), "",
                    "Number of pairs of nodes from which the typical distance is estimated. More "
                    "pairs are more accurate."},
        OptionField{"alike", &Self::alike, Closed(0, 1), "",
                    "Signatures that differ by less than this share of the typical distance show "
                    "one place; this gives a lower bound of the spacing. Higher values merge "
                    "densely spaced nodes into larger places."},
        OptionField{"reach_nodes", &Self::reach_nodes, Closed(1, 1'000'000), "",
                    "Number of nodes from which the range of similar views is estimated.",
                    OptionUse::kInternal});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// The magnitudes of all nodes in one matrix of bytes, for searching. They are compared by the sum
// of absolute differences of their square roots, so that a few strong waves don't dominate: a
// variant of eq. (2), and among the measures that were tried the one that finds true neighbours
// most often. Immutable after construction: any number of threads may query it.
class AppearanceIndex {
 public:
  AppearanceIndex() = default;
  // Copies what it needs. All signatures have the shape that `layer.described` says (WS_CHECK).
  // `poses`: of the map, for NodeDistances; null where it has none.
  explicit AppearanceIndex(const AppearanceLayer& layer, const AppearanceIndexOptions& options = {},
                           const PoseLayer* poses = nullptr);

  int size() const { return nodes_; }
  // The size of a place, in the layer's units: the distance between nodes that are next to each
  // other (the median over the nodes of the distance to the nearest other one), or the distance
  // over which signatures stay alike where that is larger, since taking an image every few
  // centimetres doesn't make places smaller. 0 with fewer than two nodes.
  double spacing() const { return spacing_; }
  const NodeDistances& distances() const { return distances_; }

  // The `count` nearest nodes (fewer when there are fewer), nearest first, ties by node; exact to
  // the bytes that magnitudes are rounded to. Nodes i with left_out[i] are skipped; an empty vector
  // skips none. The query was described as the layer was (WS_CHECK).
  std::vector<NearNode> Nearest(const FourierSignature& query, int count,
                                const std::vector<bool>& left_out = {}) const;

  // How much two signatures differ, in the unit of NearNode::distance: about 1 for random nodes.
  double Distance(const FourierSignature& a, const FourierSignature& b) const;

 private:
  std::vector<uint8_t> BytesOf(const FourierSignature& signature) const;
  double TypicalDistance(int pairs) const;
  double MedianSpacing() const;
  double ComputeReach(const AppearanceIndexOptions& options) const;
  uint32_t DistanceBelow(const uint8_t* query, int node, uint32_t limit) const;

  int nodes_ = 0;
  int rows_ = 0;
  int columns_ = 0;
  int stride_ = 1;
  float levels_per_unit_ = 1;
  double typical_ = 1;  // sum of differences of two random nodes
  double spacing_ = 0;
  NodeDistances distances_;
  std::vector<uint8_t> bytes_;  // node after node, frequency after frequency, row after row
};

}  // namespace waystone
