// SPDX-License-Identifier: Apache-2.0
#include "localizer/index/spacing_parallax.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "core/robust/median.h"
#include "localizer/index/node_bearings.h"

namespace waystone {
namespace {

struct NodePair {
  int a = 0;
  int b = 0;
  double apart = 0;  // in the layer's units
};

// The node after `a` in its sequence whose distance is nearest to a spacing.
std::optional<NodePair> FindPartner(const AppearanceLayer& layer, int a, double spacing,
                                    int max_apart) {
  const std::vector<AppearanceNode>& nodes = layer.nodes;
  std::optional<NodePair> best;
  const int end = std::min<int>(std::ssize(nodes), a + 1 + max_apart);
  for (int b = a + 1; b < end && nodes[b].sequence == nodes[a].sequence; ++b) {
    const double apart =
        std::hypot(nodes[a].pose.x - nodes[b].pose.x, nodes[a].pose.y - nodes[b].pose.y);
    if (apart < spacing / 2 || apart > 2 * spacing) continue;
    if (best && std::abs(apart - spacing) >= std::abs(best->apart - spacing)) continue;
    best = NodePair{a, b, apart};
  }
  return best;
}

std::vector<NodePair> ChoosePairs(const AppearanceLayer& layer, double spacing,
                                  const SpacingParallaxOptions& options) {
  const auto nodes = static_cast<int>(layer.nodes.size());
  const int count = std::min(nodes, options.pairs);
  std::vector<NodePair> pairs;
  for (int i = 0; i < count; ++i) {
    const auto a = static_cast<int>(static_cast<int64_t>(i) * nodes / count);
    const auto pair = FindPartner(layer, a, spacing, options.max_apart);
    if (pair) pairs.push_back(*pair);
  }
  return pairs;
}

}  // namespace

void SpacingParallaxOptions::Check() const {
  match.Check();
  relative.Check();
  CheckFields("spacing_parallax", *this);
}

double MedianParallax(const MatchedRays& rays, const RelativePose& pose) {
  if (pose.inliers.empty()) return 0;
  std::vector<double> angles;
  for (const int i : pose.inliers) {
    const double cosine = (pose.b_from_a * rays.a[i]).dot(rays.b[i]);
    angles.push_back(std::acos(std::clamp(cosine, -1.0, 1.0)));
  }
  return Median(std::move(angles));
}

double MeasureSpacingParallax(const AppearanceLayer& layer, FeatureType type, double spacing,
                              const SpacingParallaxOptions& options) {
  options.Check();
  const std::vector<NodePair> pairs = ChoosePairs(layer, spacing, options);
  std::vector<std::optional<double>> per_spacing(pairs.size());
  tbb::parallel_for(size_t{0}, pairs.size(), [&](size_t i) {
    const NodeFeatures& a = layer.nodes[pairs[i].a].features;
    const NodeFeatures& b = layer.nodes[pairs[i].b].features;
    if (a.bearings.empty() || b.bearings.empty()) return;
    const MatchedRays rays =
        MatchBearings(ToBearingFeatures(a, type), ToBearingFeatures(b, type), options.match);
    const RelativePose pose = FindRelativePose(rays, options.relative);
    if (pose.accepted()) per_spacing[i] = spacing * MedianParallax(rays, pose) / pairs[i].apart;
  });
  std::vector<double> measured;
  for (const auto& parallax : per_spacing) {
    if (parallax) measured.push_back(*parallax);
  }
  return measured.empty() ? 0 : Median(std::move(measured));
}

}  // namespace waystone
