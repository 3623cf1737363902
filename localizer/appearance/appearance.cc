// SPDX-License-Identifier: Apache-2.0
#include "localizer/appearance/appearance.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/check.h"
#include "core/base/clock.h"
#include "core/base/error.h"
#include "core/base/option_range.h"
#include "localizer/appearance/panorama_series.h"

namespace waystone {
namespace {

constexpr double kPanoramaRatio = 2;
constexpr double kRatioTolerance = 0.02;  // as ToPanorama's

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
  best.sigma_rad = heading.sigma_rad;
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
                            ProbabilityOf(evidence, model), nodes[i].cost, nodes[i].inliers,
                            nodes[i].query_from_node});
    const bool elsewhere = AreElsewhere(index, nodes[0].node, nodes[i].node, options);
    if (elsewhere && !answer.node_runner_up) answer.node_runner_up = answer.nodes.back();
  }
  answer.probability = answer.nodes.front().probability;
  // A panorama was taken at one place: what looks as well elsewhere takes its share.
  if (answer.node_runner_up) {
    answer.probability *=
        answer.probability / (answer.probability + answer.node_runner_up->probability);
  }
  answer.decided_by = verified ? "panorama_features" : "panorama_signature";
  if (answer.probability >= options.min_probability) {
    answer.verdict = Verdict::kLocalized;
    return;
  }
  // Whether the place would have been believed if nothing elsewhere were like it.
  AppearanceEvidence alone = EvidenceOf(index, nodes, 0, options);
  alone.verified = verified;
  alone.margin = options.max_margin;
  alone.log_inlier_margin = alone.log_inliers;
  const bool alike =
      answer.node_runner_up && ProbabilityOf(alone, model) >= options.min_probability;
  answer.verdict = alike ? Verdict::kAmbiguous : Verdict::kNotInMap;
  answer.message = alike
                       ? "several mapped places match this panorama; move on and send a series"
                       : "no mapped panorama matches closely enough; map the place or send another "
                         "panorama";
}

Answer Signed(const MapIndex& index) {
  Answer answer;
  answer.map = index.map().info.name;
  answer.map_version = index.map().info.version;
  return answer;
}

PanoramaQuery DescribeAppearance(const MapIndex& index, const cv::Mat& grey) {
  WS_CHECK(index.HasAppearance(), "the map has no appearance layer");
  PanoramaQuery query;
  query.signature = Signature(ToPanorama(grey), index.map().appearance->described);
  return query;
}

// ToPanorama bears an image that is a little narrower or wider than twice its height; faces don't.
BearingFeatures FeaturesOf(const MapIndex& index, const cv::Mat& grey,
                           const PanoramaQueryOptions& options) {
  PanoramaFeatureOptions features = options.features;
  features.bearings.features.type = index.map().info.feature_type;
  const int rows = std::max(1, grey.cols / 2);
  if (grey.cols == 2 * grey.rows) return ExtractPanoramaFeatures(grey, features);
  cv::Mat whole;
  cv::resize(grey, whole, {2 * rows, rows}, 0, 0, cv::INTER_AREA);
  return ExtractPanoramaFeatures(whole, features);
}

// Whether the appearance alone is sure of the place.
bool IsSettled(const MapIndex& index, const std::vector<ComparedNode>& nodes,
               const PanoramaQueryOptions& options) {
  if (nodes.empty()) return true;
  const AppearanceEvidence evidence = EvidenceOf(index, nodes, 0, options);
  const AppearanceVerdict model = VerdictFor(*index.map().appearance, false);
  return ProbabilityOf(evidence, model) >= options.settled_probability;
}

}  // namespace

void PanoramaQueryOptions::Check() const {
  CheckRange("candidates", candidates, 1, 1000);
  CheckRange("verified_candidates", verified_candidates, 1, 1000);
  CheckRange("phase_weight", phase_weight, 0, 10);
  phases.Check();
  compass.Check();
  CheckRange("phase_deviation_rad", phase_sigma_rad, 0.001, 3);
  features.Check();
  match.Check();
  CheckRange("settled_probability", settled_probability, 0.5, 1);
  CheckRange("max_poses", max_poses, 1, 1000);
  CheckRange("photo_features", photo_features, 10, 100'000);
  CheckRange("photo_neighbours", photo_neighbours, 2, 1000);
  CheckRange("photo_probes", photo_probes, 1, 32768);
  CheckRange("photo_candidates", photo_candidates, 1, 10'000);
  relative.Check();
  CheckRange("interpolation_cost", interpolation_cost, 0.001, 10);
  CheckRange("direction_deviation_rad", direction_sigma_rad, 0.001, 1);
  CheckRange("elsewhere_spacings", elsewhere_spacings, 1, 1000);
  CheckRange("max_margin", max_margin, 0.001, 10);
  CheckRange("agreement_rad", agreement_rad, 0.01, 3);
  CheckRange("min_probability", min_probability, 1e-6, 1 - 1e-6);
}

bool IsPanoramic(const cv::Size& size) {
  const double ratio = static_cast<double>(size.width) / std::max(1, size.height);
  return std::abs(ratio / kPanoramaRatio - 1) <= kRatioTolerance;
}

PanoramaQuery DescribeQuery(const MapIndex& index, const cv::Mat& grey,
                            const PanoramaQueryOptions& options) {
  PanoramaQuery query = DescribeAppearance(index, grey);
  if (options.verify && KeepsFeatures(*index.map().appearance)) {
    query.features = FeaturesOf(index, grey, options);
  }
  return query;
}

Answer AnswerFor(const MapIndex& index, const FourierSignature& query,
                 std::vector<ComparedNode> nodes, bool verified,
                 const PanoramaQueryOptions& options) {
  Answer answer = Signed(index);
  if (nodes.empty()) {
    answer.message = "the appearance layer has no other node to compare with; map more places";
    return answer;
  }
  if (nodes.front().inliers == 0 && options.fine_heading) {
    RefineHeading(index, query, nodes.front(), options);
  }
  Judge(index, nodes, verified, options, answer);
  const PlacedQuery placed = PlaceQuery(index, nodes, options);
  const AppearanceLayer& layer = *index.map().appearance;
  answer.panorama = LayerPlace{RefOf(index, layer.nodes[NearestTo(index, nodes, placed.pose)]),
                               placed.pose, placed.sigma, layer.metres_per_unit};
  if (answer.verdict == Verdict::kLocalized) {
    answer.heading = Heading{placed.pose.theta_rad, nodes.front().sigma_rad, "layer"};
  }
  return answer;
}

Answer LocatePanorama(const MapIndex& index, const PanoramaQuery& query,
                      const PanoramaQueryOptions& options, const std::vector<bool>& left_out) {
  options.Check();
  WS_CHECK(index.HasAppearance(), "the map has no appearance layer");
  const auto start = Clock::now();
  Answer answer = AnswerFor(index, query.signature, CompareQuery(index, query, options, left_out),
                            query.features.has_value(), options);
  answer.timing.verify_ms = answer.timing.total_ms = MillisecondsSince(start);
  return answer;
}

Answer RefusePanorama(const MapIndex& index, const MapError& error) {
  Answer answer = Signed(index);
  answer.verdict = Verdict::kBadImage;
  answer.decided_by = InfoOf(error.code()).name;
  answer.message = error.what();
  return answer;
}

Answer LocalizePanorama(const MapIndex& index, const cv::Mat& grey,
                        const PanoramaQueryOptions& options) {
  options.Check();
  const auto start = Clock::now();
  try {
    PanoramaQuery query = DescribeAppearance(index, grey);
    double extract_ms = MillisecondsSince(start);
    const bool may_verify = options.verify && KeepsFeatures(*index.map().appearance);
    PanoramaQueryOptions alone = options;
    alone.verify = false;
    std::vector<ComparedNode> nodes = CompareQuery(index, query, alone, {});
    if (may_verify && !IsSettled(index, nodes, options)) {
      const auto before = Clock::now();
      query.features = FeaturesOf(index, grey, options);
      extract_ms += MillisecondsSince(before);
      nodes = CompareQuery(index, query, options, {});
    }
    const bool verified = query.features.has_value();
    Answer answer = AnswerFor(index, query.signature, nodes, verified, options);
    SeriesOptions series;
    series.query = options;
    if (answer.verdict != Verdict::kNotInMap) {
      answer.belief = BeliefAfter(index, nodes, verified, {}, series);
    }
    answer.timing.extract_ms = extract_ms;
    answer.timing.total_ms = MillisecondsSince(start);
    answer.timing.verify_ms = answer.timing.total_ms - extract_ms;
    return answer;
  } catch (const MapError& error) {
    if (error.code() != ErrorCode::kBadImage) throw;
    Answer answer = RefusePanorama(index, error);
    answer.timing.extract_ms = answer.timing.total_ms = MillisecondsSince(start);
    return answer;
  }
}

}  // namespace waystone
