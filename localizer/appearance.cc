// SPDX-License-Identifier: Apache-2.0
#include "localizer/appearance.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/option_range.h"

namespace waystone {
namespace {

constexpr double kPanoramaRatio = 2;
constexpr double kRatioTolerance = 0.02;  // as ToPanorama's

using Clock = std::chrono::steady_clock;

double MillisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

bool KeepsFeatures(const AppearanceLayer& layer) {
  return std::ranges::any_of(layer.nodes,
                             [](const auto& node) { return !node.features.bearings.empty(); });
}

// The node nearest to where the query is, among those that were compared.
int NearestTo(const MapIndex& index, const std::vector<ComparedNode>& nodes, const Pose2& pose) {
  const auto apart = [&](const ComparedNode& compared) {
    const Pose2& at = index.map().appearance->nodes[compared.node].pose;
    return std::hypot(at.x - pose.x, at.y - pose.y);
  };
  return std::ranges::min_element(nodes, {}, apart)->node;
}

// The best node's heading by the warping search, which bears a motion.
void RefineHeading(const MapIndex& index, const FourierSignature& query, ComparedNode& best,
                   const PanoramaQueryOptions& options) {
  const AppearanceNode& node = index.map().appearance->nodes[best.node];
  const CompassHeading heading = RelativeHeading(node.signature, query, options.compass);
  best.heading_rad = WrappedAngle(node.pose.theta_rad + heading.heading_rad);
  best.deviation_rad = heading.deviation_rad;
}

// Candidates with their probabilities, and the verdict of them.
void Judge(const MapIndex& index, const std::vector<ComparedNode>& nodes, bool verified,
           const PanoramaQueryOptions& options, Answer& answer) {
  const AppearanceLayer& layer = *index.map().appearance;
  const AppearanceVerdict model = VerdictFor(layer, verified);
  for (size_t i = 0; i < nodes.size(); ++i) {
    AppearanceEvidence evidence = EvidenceOf(index, nodes, i, options);
    evidence.verified = verified;
    answer.nodes.push_back({RefOf(index, layer.nodes[nodes[i].node]),
                            ProbabilityOf(evidence, model), nodes[i].cost, nodes[i].inliers});
    const bool elsewhere = AreElsewhere(index, nodes[0].node, nodes[i].node, options);
    if (elsewhere && !answer.node_runner_up) answer.node_runner_up = answer.nodes.back();
  }
  answer.probability = answer.nodes.front().probability;
  answer.decided_by = verified ? "panorama_features" : "panorama_signature";
  if (answer.probability >= options.min_probability) {
    answer.verdict = Verdict::kLocalized;
    return;
  }
  // Whether the place would have been believed if nothing elsewhere were like it.
  AppearanceEvidence alone = EvidenceOf(index, {nodes.front()}, 0, options);
  alone.verified = verified;
  const bool alike =
      answer.node_runner_up && ProbabilityOf(alone, model) >= options.min_probability;
  answer.verdict = alike ? Verdict::kAmbiguous : Verdict::kNotInMap;
  answer.message = alike ? "several places of the map look like this panorama; move on and send a "
                           "series"
                         : "no panorama of the map is enough like this one; map the place, or send "
                           "another panorama";
}

Answer Signed(const MapIndex& index) {
  Answer answer;
  answer.map = index.map().info.name;
  answer.map_version = index.map().info.version;
  return answer;
}

}  // namespace

void PanoramaQueryOptions::Check() const {
  CheckRange("candidates", candidates, 1, 1000);
  CheckRange("verified_candidates", verified_candidates, 1, 1000);
  CheckRange("phase_weight", phase_weight, 0, 10);
  phases.Check();
  compass.Check();
  CheckRange("phase_deviation_rad", phase_deviation_rad, 0.001, 3);
  features.Check();
  match.Check();
  CheckRange("max_poses", max_poses, 1, 1000);
  relative.Check();
  CheckRange("interpolation_cost", interpolation_cost, 0.001, 10);
  CheckRange("direction_deviation_rad", direction_deviation_rad, 0.001, 1);
  CheckRange("elsewhere_spacings", elsewhere_spacings, 1, 1000);
  CheckRange("max_margin", max_margin, 0.001, 10);
  CheckRange("min_probability", min_probability, 1e-6, 1 - 1e-6);
}

bool IsPanoramic(const cv::Mat& image) {
  const double ratio = static_cast<double>(image.cols) / std::max(1, image.rows);
  return std::abs(ratio / kPanoramaRatio - 1) <= kRatioTolerance;
}

PanoramaQuery DescribeQuery(const MapIndex& index, const cv::Mat& grey,
                            const PanoramaQueryOptions& options) {
  WS_CHECK(index.HasAppearance(), "the map has no appearance layer");
  const AppearanceLayer& layer = *index.map().appearance;
  PanoramaQuery query;
  query.signature = Signature(ToPanorama(grey), layer.described);
  if (!options.verify || !KeepsFeatures(layer)) return query;
  PanoramaFeatureOptions features = options.features;
  features.bearings.features.type = index.map().info.feature_type;
  query.features = ExtractPanoramaFeatures(grey, features);
  return query;
}

Answer LocatePanorama(const MapIndex& index, const PanoramaQuery& query,
                      const PanoramaQueryOptions& options, const std::vector<bool>& left_out) {
  options.Check();
  WS_CHECK(index.HasAppearance(), "the map has no appearance layer");
  const auto start = Clock::now();
  Answer answer = Signed(index);
  std::vector<ComparedNode> nodes = CompareQuery(index, query, options, left_out);
  answer.timing.verify_ms = answer.timing.total_ms = MillisecondsSince(start);
  if (nodes.empty()) {
    answer.message = "the map's appearance layer has no node left to compare with; map more places";
    return answer;
  }
  const bool verified = query.features.has_value();
  if (nodes.front().inliers == 0 && options.fine_heading) {
    RefineHeading(index, query.signature, nodes.front(), options);
  }
  Judge(index, nodes, verified, options, answer);
  const PlacedQuery placed = PlaceQuery(index, nodes, options);
  const AppearanceLayer& layer = *index.map().appearance;
  answer.panorama = LayerPlace{RefOf(index, layer.nodes[NearestTo(index, nodes, placed.pose)]),
                               placed.pose, placed.deviation, layer.metres_per_unit};
  if (answer.verdict == Verdict::kLocalized) {
    answer.heading = Heading{placed.pose.theta_rad, nodes.front().deviation_rad, "layer"};
  }
  answer.timing.verify_ms = answer.timing.total_ms = MillisecondsSince(start);
  return answer;
}

Answer LocalizePanorama(const MapIndex& index, const cv::Mat& grey,
                        const PanoramaQueryOptions& options) {
  const auto start = Clock::now();
  try {
    const PanoramaQuery query = DescribeQuery(index, grey, options);
    const double extract_ms = MillisecondsSince(start);
    Answer answer = LocatePanorama(index, query, options);
    answer.timing.extract_ms = extract_ms;
    answer.timing.total_ms += extract_ms;
    return answer;
  } catch (const MapError& error) {
    if (error.code() != ErrorCode::kBadImage) throw;
    Answer answer = Signed(index);
    answer.verdict = Verdict::kBadImage;
    answer.decided_by = InfoOf(error.code()).name;
    answer.message = error.what();
    answer.timing.extract_ms = answer.timing.total_ms = MillisecondsSince(start);
    return answer;
  }
}

}  // namespace waystone
