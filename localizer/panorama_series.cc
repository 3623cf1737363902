// SPDX-License-Identifier: Apache-2.0
#include "localizer/panorama_series.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/base/option_range.h"

namespace waystone {
namespace {

// The log odds that the image is of a node if nothing else were like it, bounded.
double LogOdds(const MapIndex& index, const ComparedNode& node, bool verified,
               const AppearanceVerdict& model, const SeriesOptions& options) {
  AppearanceEvidence evidence = EvidenceOf(index, {node}, 0, options.query);
  evidence.verified = verified;
  const double p = ProbabilityOf(evidence, model);
  const double log_odds = std::log(p) - std::log1p(-p);
  return std::clamp(log_odds, -options.max_log_odds, options.max_log_odds);
}

std::vector<NodeEvidence> EvidenceOfNodes(const MapIndex& index,
                                          const std::vector<ComparedNode>& compared, bool verified,
                                          const SeriesOptions& options) {
  const AppearanceLayer& layer = *index.map().appearance;
  const AppearanceVerdict model = VerdictFor(layer, verified);
  // Nodes that weren't near enough to be compared, of whose heading nothing is known.
  NodeEvidence other;
  other.log_likelihood = -options.max_log_odds;
  other.deviation_rad = std::numbers::pi;
  std::vector<NodeEvidence> evidence(layer.nodes.size(), other);
  for (const ComparedNode& node : compared) {
    evidence[node.node] = {LogOdds(index, node, verified, model, options), node.heading_rad,
                           std::max(node.deviation_rad, 1e-3)};
  }
  return evidence;
}

GraphFilterOptions FilterFor(const MapIndex& index, const SeriesOptions& options) {
  const double spacing = std::max(index.appearance().spacing(), 1e-9);
  GraphFilterOptions filter = options.filter;
  filter.position_deviation = options.position_spacings * spacing;
  filter.step_deviation = options.step_spacings * spacing;
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
  answer.decided_by = "series";
  const Eigen::Vector2d at = sum / here;
  answer.panorama->pose = {at.x(), at.y(), best.heading_rad};
  answer.panorama->deviation = options.position_spacings * index.appearance().spacing();
  answer.panorama->node = RefOf(index, layer.nodes[best.node]);
  const bool sure = answer.probability >= options.query.min_probability;
  answer.verdict = sure ? Verdict::kLocalized : Verdict::kAmbiguous;
  answer.heading.reset();
  answer.message = "several places of the map fit what was seen so far; move on";
  if (!sure) return;
  answer.heading = Heading{best.heading_rad, best.deviation_rad, "layer"};
  answer.message.clear();
}

}  // namespace

void SeriesOptions::Check() const {
  query.Check();
  filter.Check();
  CheckRange("position_spacings", position_spacings, 0.01, 1000);
  CheckRange("step_spacings", step_spacings, 0.01, 1000);
  CheckRange("max_log_odds", max_log_odds, 0.1, 100);
}

SeriesStep ContinueSeries(const MapIndex& index, const PanoramaQuery& query,
                          const FilterState& previous, const std::optional<Pose2>& odometry,
                          const SeriesOptions& options) {
  options.Check();
  SeriesStep step{LocatePanorama(index, query, options.query), previous};
  if (step.answer.verdict == Verdict::kNotInMap) return step;
  std::vector<Pose2> poses;
  for (const AppearanceNode& node : index.map().appearance->nodes) poses.push_back(node.pose);
  const std::vector<ComparedNode> compared = CompareQuery(index, query, options.query, {});
  const std::vector<NodeEvidence> evidence =
      EvidenceOfNodes(index, compared, query.features.has_value(), options);
  step.state = UpdateBelief(poses, evidence, previous, odometry, FilterFor(index, options)).state;
  TakeBelief(index, step.state, options, step.answer);
  return step;
}

}  // namespace waystone
