// SPDX-License-Identifier: Apache-2.0
#include "localizer/appearance/panorama_series.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/base/clock.h"
#include "core/base/error.h"

namespace waystone {
namespace {

// The probability that the image was taken at a node if nothing elsewhere looked like it.
double AloneProbability(const MapIndex& index, const std::vector<ComparedNode>& compared, size_t at,
                        bool verified, const AppearanceVerdict& model,
                        const SeriesOptions& options) {
  AppearanceEvidence evidence = CollectEvidence(index, compared, at, options.query);
  evidence.verified = verified;
  evidence.margin = options.query.max_margin;
  evidence.log_inlier_margin = evidence.log_inliers;
  return EstimateProbability(evidence, model);
}

std::vector<NodeEvidence> CollectNodeEvidence(const MapIndex& index,
                                              const std::vector<ComparedNode>& compared,
                                              bool verified, const SeriesOptions& options) {
  const AppearanceLayer& layer = *index.map().appearance;
  const AppearanceVerdict model = VerdictFor(layer, verified);
  // Nodes that weren't similar enough to be compared, for which no heading is known.
  NodeEvidence other;
  other.log_likelihood = -options.max_log_odds;
  other.sigma_rad = std::numbers::pi;
  std::vector<NodeEvidence> evidence(layer.nodes.size(), other);
  for (size_t at = 0; at < compared.size(); ++at) {
    const ComparedNode& node = compared[at];
    const double p = AloneProbability(index, compared, at, verified, model, options);
    const double log_odds = std::log(p) - std::log1p(-p);
    evidence[node.node] = {std::clamp(log_odds, -options.max_log_odds, options.max_log_odds),
                           node.heading_rad, std::max(node.sigma_rad, 1e-3)};
  }
  return evidence;
}

GraphFilterOptions FilterFor(const MapIndex& index, const SeriesOptions& options) {
  const double spacing = std::max(index.appearance().spacing(), 1e-9);
  GraphFilterOptions filter = options.filter;
  filter.position_sigma = options.position_spacings * spacing;
  filter.step_sigma = options.step_spacings * spacing;
  return filter;
}

// The belief in the place of the likeliest node, and the place: the mean of the nodes there.
void TakeBelief(const MapIndex& index, const FilterState& state, const SeriesOptions& options,
                Answer& answer) {
  const AppearanceLayer& layer = *index.map().appearance;
  const Belief& best = state.front();
  double here = 0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Belief& belief : state) {
    if (AreElsewhere(index, best.node, belief.node, options.query)) continue;
    const Pose2& pose = layer.nodes[belief.node].pose;
    here += belief.probability;
    sum += belief.probability * Eigen::Vector2d(pose.x, pose.y);
  }
  answer.probability = std::min(here, 1.0);
  answer.decided_by = DecidedBy::kSeries;
  const Eigen::Vector2d at = sum / here;
  answer.panorama->pose = {at.x(), at.y(), best.heading_rad};
  const double sigma = options.position_spacings * index.appearance().spacing();
  answer.panorama->sigma = sigma;
  answer.panorama->covariance = sigma * sigma * Eigen::Matrix2d::Identity();
  answer.panorama->node = RefOf(index, layer.nodes[best.node]);
  const bool sure = answer.probability >= options.query.min_probability;
  answer.verdict = sure ? Verdict::kLocalized : Verdict::kAmbiguous;
  answer.heading.reset();
  answer.message = "several mapped places match the series so far; move on";
  if (!sure) return;
  answer.heading = Heading{best.heading_rad, best.sigma_rad, HeadingFrame::kLayer};
  answer.message.clear();
}

}  // namespace

void SeriesOptions::Check() const {
  CheckFields("series", *this);
  query.Check();
  filter.Check();
}

namespace {

// Whether the image supports the place of the previous belief.
bool IsExpected(const MapIndex& index, const std::vector<ComparedNode>& compared,
                const FilterState& previous, const PanoramaQueryOptions& options) {
  return !previous.empty() && !compared.empty() &&
         !AreElsewhere(index, previous.front().node, compared.front().node, options);
}

// The motion since the panorama before: by odometry, or a turn on the spot where both panoramas are
// otherwise the same.
std::optional<Pose2> MotionOf(const MapIndex& index, const PanoramaQuery& query,
                              const SeriesContext& context, const SeriesOptions& options) {
  constexpr double kSame = 0.05;  // of the distance between nodes at random
  if (context.odometry || !context.described) return context.odometry;
  if (index.appearance().Distance(*context.described, query.signature) > kSame) return std::nullopt;
  return Pose2{
      0, 0,
      TurnByPhases(*context.described, query.signature, options.query.phases).best.heading_rad};
}

}  // namespace

FilterState BeliefAfter(const MapIndex& index, const std::vector<ComparedNode>& compared,
                        bool verified, const SeriesContext& context, const SeriesOptions& options) {
  std::vector<Pose2> poses;
  for (const AppearanceNode& node : index.map().appearance->nodes) poses.push_back(node.pose);
  const GraphFilterOptions filter = FilterFor(index, options);
  std::vector<NodeEvidence> evidence = CollectNodeEvidence(index, compared, verified, options);
  if (context.odometry && IsExpected(index, compared, context.previous, options.query)) {
    const double independent = ShareMoved(*context.odometry, filter);
    for (NodeEvidence& node : evidence) node.log_likelihood *= independent;
  }
  return UpdateBelief(poses, evidence, context.previous, context.odometry, filter,
                      index.appearance().distances().Heights())
      .state;
}

Answer ContinueSeries(const MapIndex& index, const PanoramaQuery& query,
                      const SeriesContext& context, const SeriesOptions& options) {
  options.Check();
  const std::vector<ComparedNode> compared = CompareQuery(index, query, options.query, {});
  const bool verified = query.features.has_value();
  Answer answer = JudgeNodes(index, query.signature, compared, verified, options.query);
  answer.belief = context.previous;
  answer.described = query.signature;
  answer.decided_by = DecidedBy::kSeries;
  const AppearanceVerdict model = VerdictFor(*index.map().appearance, verified);
  if (compared.empty() ||
      AloneProbability(index, compared, 0, verified, model, options) < options.min_alone) {
    answer.verdict = Verdict::kNotInMap;
    answer.heading.reset();
    answer.message =
        "no mapped panorama matches this one of the series closely enough; send another one";
    return answer;
  }
  SeriesContext moved = context;
  moved.odometry = MotionOf(index, query, context, options);
  answer.belief = BeliefAfter(index, compared, verified, moved, options);
  TakeBelief(index, answer.belief, options, answer);
  return answer;
}

Answer LocalizeInSeries(const MapIndex& index, const cv::Mat& grey, const SeriesContext& context,
                        const SeriesOptions& options) {
  const Clock::time_point start = Clock::now();
  Answer answer;
  double extract_ms = 0;
  try {
    const PanoramaQuery query = DescribeQuery(index, grey, options.query);
    extract_ms = MillisecondsSince(start);
    answer = ContinueSeries(index, query, context, options);
  } catch (const MapError& error) {
    if (error.code() != ErrorCode::kBadImage) throw;
    answer = RefuseImage(error);
    answer.belief = context.previous;
  }
  answer.timing.total_ms = MillisecondsSince(start);
  answer.timing.extract_ms = extract_ms;
  answer.timing.verify_ms = answer.timing.total_ms - extract_ms;
  return answer;
}

}  // namespace waystone
