// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/recognise_nodes.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "builder/calibration/map_parts.h"
#include "core/base/check.h"
#include "localizer/appearance/appearance.h"
#include "localizer/index/node_bearings.h"
#include "localizer/poses/node_pose.h"

namespace waystone {
namespace {

// How many spacings two answers may be apart, and how many more for each panorama between them.
constexpr double kApartSpacings = 2;
constexpr double kStepSpacings = 3;

size_t IndexOfNode(const AppearanceLayer& layer, AppearanceNodeId id) {
  return static_cast<size_t>(std::ranges::lower_bound(layer.nodes, id, {}, &AppearanceNode::id) -
                             layer.nodes.begin());
}

bool KeepsFeatures(const AppearanceLayer& layer) {
  return std::ranges::any_of(layer.nodes,
                             [](const auto& node) { return !node.features.bearings.empty(); });
}

// Where a panorama was taken; nothing where it isn't localized.
std::optional<RecognisedNode> LocalizeNode(const MapIndex& index, const AppearanceNode& node,
                                           size_t asking, bool verify,
                                           const PanoramaQueryOptions& options) {
  PanoramaQuery query{node.signature, std::nullopt};
  if (verify && !node.features.bearings.empty()) {
    query.features = ToBearingFeatures(node.features, index.map().info.feature_type);
  }
  Answer answer = LocatePanorama(index, query, options);
  if (answer.verdict != Verdict::kLocalized || !answer.heading) return std::nullopt;
  AddNodePose(index, answer);
  const AppearanceLayer& layer = *index.map().appearance;
  const PanoramaAnswer& panorama = *answer.panorama;
  const NodeCandidate& best = panorama.candidates.front();
  return RecognisedNode{asking,
                        IndexOfNode(layer, panorama.node.id),
                        panorama.pose,
                        panorama.sigma,
                        answer.heading->sigma_rad,
                        IndexOfNode(layer, best.node.id),
                        best.query_from_node,
                        best.inliers,
                        answer.pose};
}

// Whether the answers to two consecutive panoramas agree with how these were taken.
bool Agree(const AppearanceNode& a, const RecognisedNode& found_a, const AppearanceNode& b,
           const RecognisedNode& found_b, double spacing, const LoopOptions& options) {
  const double turned = b.pose.theta_rad - a.pose.theta_rad;
  const double answered = found_b.pose.theta_rad - found_a.pose.theta_rad;
  const double steps =
      std::abs(static_cast<double>(found_b.asking) - static_cast<double>(found_a.asking));
  return std::abs(WrappedAngle(answered - turned)) <= options.agreement_rad &&
         std::hypot(found_b.pose.x - found_a.pose.x, found_b.pose.y - found_a.pose.y) <=
             (kApartSpacings + kStepSpacings * steps) * spacing;
}

}  // namespace

std::vector<RecognisedNode> RecogniseNodes(const MapData& map, const MapData& other,
                                           const LoopOptions& options,
                                           const PanoramaQueryOptions& query) {
  WS_CHECK(map.appearance && other.appearance, "maps of panoramas");
  const auto index = MapIndex::Build(CopyPanoramas(map));
  const std::vector<AppearanceNode>& nodes = other.appearance->nodes;
  const bool verify = query.verify && KeepsFeatures(*map.appearance);
  std::vector<std::optional<RecognisedNode>> found(nodes.size());
  tbb::parallel_for(size_t{0}, nodes.size(),
                    [&](size_t i) { found[i] = LocalizeNode(*index, nodes[i], i, verify, query); });
  const double spacing = index->appearance().spacing();
  const auto reach = static_cast<size_t>(options.neighbourhood);
  std::vector<RecognisedNode> recognised;
  for (size_t i = 0; i < nodes.size(); ++i) {
    if (!found[i]) continue;
    int supporters = 0;
    const size_t last = std::min(nodes.size() - 1, i + reach);
    for (size_t j = i < reach ? 0 : i - reach; j <= last; ++j) {
      if (j == i || !found[j] || nodes[j].sequence != nodes[i].sequence) continue;
      supporters += Agree(nodes[i], *found[i], nodes[j], *found[j], spacing, options);
    }
    if (supporters >= options.min_supporters) recognised.push_back(*found[i]);
  }
  return recognised;
}

}  // namespace waystone
