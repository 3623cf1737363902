// SPDX-License-Identifier: Apache-2.0
#include "localizer/appearance/panorama_series.h"

#include <algorithm>
#include <cmath>
#include <iterator>
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

FilterState BeliefAround(const MapIndex& index, const FilterState& state, int node,
                         const PanoramaQueryOptions& options) {
  FilterState around;
  std::ranges::copy_if(state, std::back_inserter(around), [&](const Belief& belief) {
    return !AreElsewhere(index, node, belief.node, options);
  });
  return around;
}

// The place by the belief alone: the mean of these nodes, and the node nearest to it.
void TakeMean(const MapIndex& index, const FilterState& around, double sigma,
              PanoramaAnswer& panorama) {
  const AppearanceLayer& layer = *index.map().appearance;
  const auto position = [&](const Belief& belief) {
    const Pose2& pose = layer.nodes[belief.node].pose;
    return Eigen::Vector2d(pose.x, pose.y);
  };
  double sum = 0;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Belief& belief : around) {
    sum += belief.probability;
    mean += belief.probability * position(belief);
  }
  mean /= sum;
  const Belief& nearest = *std::ranges::min_element(
      around, {}, [&](const Belief& belief) { return (position(belief) - mean).norm(); });
  panorama.node = RefOf(index, layer.nodes[nearest.node]);
  panorama.pose = {mean.x(), mean.y(), 0};
  panorama.sigma = sigma;
  panorama.covariance = sigma * sigma * Eigen::Matrix2d::Identity();
}

// The verdict of the belief, with the heading at its likeliest node or at `seen`.
void Decide(const FilterState& around, std::optional<int> seen, const SeriesOptions& options,
            Answer& answer) {
  answer.probability = 0;
  for (const Belief& belief : around) answer.probability += belief.probability;
  answer.probability = std::min(answer.probability, 1.0);
  const auto of_seen = std::ranges::find(around, seen.value_or(-1), &Belief::node);
  const Belief& best = of_seen == around.end() ? around.front() : *of_seen;
  answer.panorama->pose.theta_rad = best.heading_rad;
  const bool sure = answer.probability >= options.query.min_probability;
  answer.verdict = sure ? Verdict::kLocalized : Verdict::kAmbiguous;
  answer.heading.reset();
  answer.message = "several mapped places match the series so far; move on";
  if (!sure) return;
  answer.heading = Heading{best.heading_rad, best.sigma_rad, HeadingFrame::kLayer};
  answer.message.clear();
}

// The belief decides among places. Within one it is coarse: max_log_odds makes the nodes that see
// the image equally likely. So the position and the nearest node there are the image's (PlaceQuery)
// unless it doesn't support the place by itself.
void TakeBelief(const MapIndex& index, const std::vector<ComparedNode>& compared, bool verified,
                const FilterState& state, const SeriesOptions& options, Answer& answer) {
  const int likeliest = state.front().node;
  const auto seen = std::ranges::find_if(compared, [&](const ComparedNode& node) {
    return !AreElsewhere(index, likeliest, node.node, options.query);
  });
  const size_t at = seen - compared.begin();
  const AppearanceVerdict model = VerdictFor(*index.map().appearance, verified);
  if (seen != compared.end() &&
      AloneProbability(index, compared, at, verified, model, options) >= options.min_alone) {
    TakePlace(index, compared, options.query, at, *answer.panorama);
    Decide(BeliefAround(index, state, seen->node, options.query), seen->node, options, answer);
    return;
  }
  const FilterState around = BeliefAround(index, state, likeliest, options.query);
  TakeMean(index, around, options.position_spacings * index.appearance().spacing(),
           *answer.panorama);
  Decide(around, std::nullopt, options, answer);
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
  TakeBelief(index, compared, verified, answer.belief, options, answer);
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
