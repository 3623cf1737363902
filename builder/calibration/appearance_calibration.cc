// SPDX-License-Identifier: Apache-2.0
#include "builder/calibration/appearance_calibration.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "builder/calibration/rendered_negatives.h"
#include "core/base/check.h"
#include "localizer/appearance/appearance_match.h"

namespace waystone {
namespace {

double Apart(const Pose2& a, const Pose2& b) { return std::hypot(a.x - b.x, a.y - b.y); }

// The nodes that a query is asked for without.
std::vector<bool> Around(const AppearanceLayer& layer, const AppearanceCalibrationQuery& query,
                         double radius) {
  std::vector<bool> around;
  for (const AppearanceNode& node : layer.nodes) {
    around.push_back(radius > 0 && Apart(node.pose, query.truth) <= radius);
  }
  if (query.node >= 0) around[query.node] = true;
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
  sample.evidence = CollectEvidence(index, nodes, 0, options);
  sample.evidence.verified = query.features.has_value();
  sample.right = truth && Apart(PlaceQuery(index, nodes, options).pose, *truth) <= right_radius;
  return sample;
}

// The map as far as its panoramas are asked for.
MapData PanoramasOf(const MapData& map) {
  MapData part;
  part.info = map.info;
  part.sequences = map.sequences;
  part.appearance = map.appearance;
  for (AppearanceNode& node : part.appearance->nodes) node.jpeg.clear();
  return part;
}

std::vector<PanoramaQuery> DescribeNegatives(const MapIndex& index,
                                             const AppearanceCalibrationOptions& options) {
  const SignatureOptions& described = index.map().appearance->described;
  const int width_px = std::max(512, 2 * std::max(described.k1, described.k2));
  const auto pictures = RenderedPanoramas(options.rendered_negatives, width_px);
  std::vector<PanoramaQuery> queries(pictures.size());
  tbb::parallel_for(size_t{0}, pictures.size(), [&](size_t i) {
    queries[i] = DescribeQuery(index, pictures[i], options.query);
  });
  return queries;
}

}  // namespace

void AppearanceCalibrationOptions::Check() const {
  CheckFields("appearance_calibration", *this);
  for (const double blank : blank_spacings) {
    if (blank >= 0 && blank <= 1000) continue;
    throw MapError(ErrorCode::kBadOptions, "appearance_calibration.blank_spacings has " +
                                               std::to_string(blank) +
                                               "; each must be between 0 and 1000");
  }
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

std::vector<AppearanceCalibrationQuery> QueriesOfNodes(const MapIndex& index, int max_nodes,
                                                       const PanoramaQueryOptions& options) {
  const std::vector<AppearanceNode>& nodes = index.map().appearance->nodes;
  const auto all = static_cast<int>(nodes.size());
  const int count = std::min(all, max_nodes);
  std::vector<AppearanceCalibrationQuery> queries;
  for (int i = 0; i < count; ++i) {
    const auto node = static_cast<int>(static_cast<int64_t>(i) * all / count);
    queries.push_back({QueryOfNode(index, node, options), nodes[node].pose, node});
  }
  return queries;
}

AppearanceVerdict CalibrateAppearance(const MapIndex& index,
                                      const std::vector<AppearanceCalibrationQuery>& queries,
                                      const std::vector<PanoramaQuery>& outside, bool verified,
                                      const AppearanceCalibrationOptions& options,
                                      const std::function<void()>& before_each) {
  options.Check();
  WS_CHECK(index.HasAppearance(), "the map has no appearance layer");
  const AppearanceLayer& layer = *index.map().appearance;
  const double spacing = index.appearance().spacing();
  const size_t blanks = options.blank_spacings.size();
  const size_t asked = queries.size() * blanks;
  std::vector<std::optional<AppearanceSample>> found(asked + outside.size());
  tbb::parallel_for(size_t{0}, found.size(), [&](size_t i) {
    if (before_each) before_each();
    if (i >= asked) {
      found[i] = SampleOf(index, outside[i - asked], {}, 0, {}, options.query);
      return;
    }
    const AppearanceCalibrationQuery& query = queries[i / blanks];
    const double radius = options.blank_spacings[i % blanks] * spacing;
    found[i] = SampleOf(index, query.query, query.truth, options.right_spacings * spacing,
                        Around(layer, query, radius), options.query);
  });
  std::vector<AppearanceSample> samples;
  for (const auto& sample : found) {
    if (sample && sample->evidence.verified == verified) samples.push_back(*sample);
  }
  return FitAppearanceVerdict(samples, verified, options.fit);
}

void CalibrateAppearanceLayer(MapData& map, const std::vector<AppearanceSampleFrame>& samples,
                              const AppearanceCalibrationOptions& options,
                              ProgressReporter& progress) {
  const auto report = [&] { progress.Report("calibration", 0, 1); };
  const auto index = MapIndex::Build(PanoramasOf(map));
  const std::vector<PanoramaQuery> outside = DescribeNegatives(*index, options);
  std::vector<AppearanceCalibrationQuery> verified;
  std::vector<AppearanceCalibrationQuery> alone;
  for (const AppearanceSampleFrame& sample : samples) {
    alone.push_back({{sample.signature, std::nullopt}, sample.pose, sample.node});
    if (sample.features.size() == 0) continue;
    verified.push_back({{sample.signature, sample.features}, sample.pose, sample.node});
  }
  std::vector<PanoramaQuery> outside_alone;
  for (const PanoramaQuery& query : outside) {
    outside_alone.push_back({query.signature, std::nullopt});
  }
  map.appearance->verdict =
      CalibrateAppearance(*index, alone, outside_alone, false, options, report);
  if (verified.empty()) return;
  map.appearance->verified_verdict =
      CalibrateAppearance(*index, verified, outside, true, options, report);
}

}  // namespace waystone
