// SPDX-License-Identifier: Apache-2.0
#include "builder/appearance_calibration.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/check.h"
#include "core/base/option_range.h"
#include "localizer/appearance_match.h"

namespace waystone {
namespace {

double Apart(const Pose2& a, const Pose2& b) { return std::hypot(a.x - b.x, a.y - b.y); }

std::vector<bool> Around(const AppearanceLayer& layer, int node, double radius) {
  std::vector<bool> around;
  for (const AppearanceNode& other : layer.nodes) {
    around.push_back(Apart(other.pose, layer.nodes[node].pose) <= radius);
  }
  around[node] = true;
  return around;
}

// The evidence for the best answer, and whether it is right: nothing where no node is left.
std::optional<AppearanceSample> SampleOf(const MapIndex& index, const PanoramaQuery& query,
                                         const std::optional<Pose2>& truth, double right_radius,
                                         const std::vector<bool>& left_out,
                                         const PanoramaQueryOptions& options) {
  const std::vector<ComparedNode> nodes = CompareQuery(index, query, options, left_out);
  if (nodes.empty()) return std::nullopt;
  AppearanceSample sample;
  sample.evidence = EvidenceOf(index, nodes, 0, options);
  sample.evidence.verified = query.features.has_value();
  sample.right = truth && Apart(PlaceQuery(index, nodes, options).pose, *truth) <= right_radius;
  return sample;
}

std::vector<int> SpreadNodes(int nodes, int max_nodes) {
  const int count = std::min(nodes, max_nodes);
  std::vector<int> spread;
  for (int i = 0; i < count; ++i) {
    spread.push_back(static_cast<int>(static_cast<int64_t>(i) * nodes / count));
  }
  return spread;
}

}  // namespace

void AppearanceCalibrationOptions::Check() const {
  CheckRange("max_nodes", max_nodes, 1, 100'000);
  CheckRange("right_spacings", right_spacings, 0.1, 100);
  CheckRange("blank_spacings", blank_spacings, 1, 1000);
  query.Check();
  fit.Check();
}

PanoramaQuery QueryOfNode(const MapIndex& index, int node, const PanoramaQueryOptions& options) {
  const AppearanceNode& kept = index.map().appearance->nodes[node];
  PanoramaQuery query{kept.signature, std::nullopt};
  if (options.verify && !kept.features.bearings.empty()) {
    query.features = ToBearingFeatures(kept.features, index.map().info.feature_type);
  }
  return query;
}

AppearanceVerdict CalibrateAppearance(const MapIndex& index,
                                      const std::vector<PanoramaQuery>& outside,
                                      const AppearanceCalibrationOptions& options) {
  options.Check();
  WS_CHECK(index.HasAppearance(), "the map has no appearance layer");
  const AppearanceLayer& layer = *index.map().appearance;
  const double spacing = index.appearance().spacing();
  const std::vector<int> asked =
      SpreadNodes(static_cast<int>(layer.nodes.size()), options.max_nodes);
  const bool verified = QueryOfNode(index, asked.front(), options.query).features.has_value();
  std::vector<std::optional<AppearanceSample>> found(2 * asked.size() + outside.size());
  tbb::parallel_for(size_t{0}, found.size(), [&](size_t i) {
    if (i >= 2 * asked.size()) {
      found[i] = SampleOf(index, outside[i - 2 * asked.size()], {}, 0, {}, options.query);
      return;
    }
    const int node = asked[i / 2];
    const bool blank = i % 2 == 1;
    const double radius = blank ? options.blank_spacings * spacing : 0;
    std::optional<Pose2> truth;
    if (!blank) truth = layer.nodes[node].pose;
    found[i] =
        SampleOf(index, QueryOfNode(index, node, options.query), truth,
                 options.right_spacings * spacing, Around(layer, node, radius), options.query);
  });
  std::vector<AppearanceSample> samples;
  for (const auto& sample : found) {
    if (sample && sample->evidence.verified == verified) samples.push_back(*sample);
  }
  return FitAppearanceVerdict(samples, verified, options.fit);
}

}  // namespace waystone
