// SPDX-License-Identifier: Apache-2.0
#include "core/localization/graph_filter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "core/base/check.h"
#include "core/base/error.h"

namespace waystone {
namespace {

void CheckPrevious(const FilterState& previous, size_t nodes) {
  double sum = 0;
  for (const Belief& belief : previous) {
    const bool possible = belief.node >= 0 && belief.node < static_cast<int>(nodes) &&
                          belief.probability >= 0 && std::isfinite(belief.heading_rad) &&
                          belief.sigma_rad > 0 && std::isfinite(belief.sigma_rad);
    if (!possible) {
      throw MapError(ErrorCode::kBadRequest,
                     "the previous answer has a belief in node " + std::to_string(belief.node) +
                         " that this map can't have returned; omit `previous`");
    }
    sum += belief.probability;
  }
  if (sum <= 1 + 1e-6) return;
  throw MapError(ErrorCode::kBadRequest, "the previous answer's probabilities sum to " +
                                             std::to_string(sum) + "; omit `previous`");
}

double NormalDensity(double x, double sigma) {
  const double z = x / sigma;
  return std::exp(-0.5 * z * z) / (sigma * std::sqrt(2 * std::numbers::pi));
}

// Relative rounding error of a mean of equal variances.
constexpr double kRounding = 1e-9;

// Weight of having left the graph, where a node d sigmas away weighs exp(-d^2 / 2).
const double kLeftGraph = std::exp(-0.5 * 3 * 3);

// The prior of a node, before the image, with the mean and sigma of its heading.
struct Prior {
  double weight = 0;
  double heading_x = 0;  // weighted sum of unit vectors
  double heading_y = 0;
  double variance = 0;  // weighted sum
};

class Update {
 public:
  Update(const std::vector<Pose2>& poses, const std::vector<NodeEvidence>& evidence,
         const std::vector<double>& heights, const GraphFilterOptions& options)
      : poses_(poses),
        evidence_(evidence),
        heights_(heights),
        options_(options),
        priors_(poses.size()) {}

  // The share of the belief that moves with the robot; the rest may be anywhere.
  void Move(const FilterState& previous, const std::optional<Pose2>& odometry) {
    for (const Belief& belief : previous) MoveOne(belief, odometry);
    double moved = 0;
    for (const Prior& prior : priors_) moved += prior.weight;
    anywhere_ = (1 - moved) / static_cast<double>(poses_.size());
  }

  FilterAnswer Look() const {
    double best = -std::numeric_limits<double>::infinity();
    for (const NodeEvidence& evidence : evidence_) best = std::max(best, evidence.log_likelihood);
    if (!std::isfinite(best)) {
      throw MapError(ErrorCode::kBadRequest,
                     "the image is impossible at every node; query without the previous answer");
    }
    FilterAnswer answer;
    double sum = 0;
    for (size_t i = 0; i < poses_.size(); ++i) {
      answer.state.push_back(Posterior(i, best));
      sum += answer.state.back().probability;
    }
    for (Belief& belief : answer.state) belief.probability /= sum;
    KeepLikeliest(answer.state);
    return answer;
  }

 private:
  // Where a belief's robot is by odometry.
  struct Robot {
    Pose2 pose;
    double reach = 0;  // sigma of its position
    double heading_variance = 0;
    double left = 0;  // weight of having left the graph, which only odometry shows
  };

  // Moves one belief: the part that reached other nodes, and the part that stays at its node
  // (ShareMoved).
  void MoveOne(const Belief& from, const std::optional<Pose2>& odometry) {
    const Pose2& at = poses_[from.node];
    Robot robot{.pose = {at.x, at.y, from.heading_rad},
                .reach = std::hypot(options_.position_sigma, options_.step_sigma),
                // Without odometry any turn is possible.
                .heading_variance = std::pow(std::numbers::pi, 2)};
    double moved = 1;
    if (odometry) {
      robot.left = kLeftGraph;
      moved = ShareMoved(*odometry, options_);
      // With the probability `moved` the robot has made the whole step to the next place.
      const double part = std::max(moved, 1e-6);
      robot.pose = robot.pose * Pose2{odometry->x / part, odometry->y / part, odometry->theta_rad};
      const double trajectory = std::hypot(odometry->x, odometry->y) / part;
      // An error of the heading shifts the position sideways.
      robot.reach = std::hypot(options_.position_sigma, options_.share_of_trajectory * trajectory,
                               from.sigma_rad * trajectory);
      robot.heading_variance = std::pow(from.sigma_rad, 2) + std::pow(options_.turn_sigma_rad, 2);
    }
    const double mass = (1 - options_.kidnapped) * from.probability;
    AddPrior(from.node, (1 - moved) * mass, robot);
    if (moved > 0) Spread(from.node, moved * mass, robot);
  }

  void Spread(int from, double mass, const Robot& robot) {
    double sum = robot.left;
    std::vector<double> weights(poses_.size());
    for (size_t i = 0; i < poses_.size(); ++i) {
      const double d = std::hypot(poses_[i].x - robot.pose.x, poses_[i].y - robot.pose.y,
                                  HeightBetween(from, i)) /
                       robot.reach;
      sum += weights[i] = std::exp(-0.5 * d * d);
    }
    for (size_t i = 0; i < poses_.size(); ++i) AddPrior(i, mass * weights[i] / sum, robot);
  }

  void AddPrior(size_t node, double weight, const Robot& robot) {
    priors_[node].weight += weight;
    priors_[node].heading_x += weight * std::cos(robot.pose.theta_rad);
    priors_[node].heading_y += weight * std::sin(robot.pose.theta_rad);
    priors_[node].variance += weight * robot.heading_variance;
  }

  // 0 where one of them isn't known.
  double HeightBetween(size_t a, size_t b) const {
    const double height = heights_.empty() ? 0 : heights_[a] - heights_[b];
    return std::isnan(height) ? 0 : height;
  }

  // Bayes' rule for a node: how well place and heading fit, and both headings fused.
  Belief Posterior(size_t i, double best) const {
    const NodeEvidence& seen = evidence_[i];
    const Prior& prior = priors_[i];
    const double likelihood = std::exp(seen.log_likelihood - best);
    const double flat = 1 / (2 * std::numbers::pi);  // the density of an unknown heading
    Belief belief{static_cast<int>(i), likelihood * anywhere_ * flat,
                  WrappedAngle(seen.heading_rad), seen.sigma_rad};
    if (prior.weight <= 0) return belief;
    const double mean = std::atan2(prior.heading_y, prior.heading_x);
    const double variance = prior.variance / prior.weight;
    const double off = WrappedAngle(seen.heading_rad - mean);
    const double seen_variance = seen.sigma_rad * seen.sigma_rad;
    const bool unknown = std::sqrt(variance) >= (1 - kRounding) * std::numbers::pi;
    const double fit = unknown ? flat : NormalDensity(off, std::sqrt(variance + seen_variance));
    const double moved = likelihood * prior.weight * fit;
    belief.probability += moved;
    if (unknown || moved < 0.5 * belief.probability) return belief;  // known only from the image
    belief.heading_rad = WrappedAngle(mean + off * variance / (variance + seen_variance));
    belief.sigma_rad = std::sqrt(variance * seen_variance / (variance + seen_variance));
    return belief;
  }

  void KeepLikeliest(FilterState& state) const {
    std::erase_if(state, [](const Belief& belief) { return belief.probability <= 0; });
    std::stable_sort(state.begin(), state.end(), [](const Belief& a, const Belief& b) {
      return a.probability > b.probability;
    });
    if (std::ssize(state) > options_.max_beliefs) state.resize(options_.max_beliefs);
  }

  const std::vector<Pose2>& poses_;
  const std::vector<NodeEvidence>& evidence_;
  const std::vector<double>& heights_;
  const GraphFilterOptions& options_;
  std::vector<Prior> priors_;
  double anywhere_ = 0;  // weight of every node for a robot that may be anywhere
};

}  // namespace

void GraphFilterOptions::Check() const { CheckFields("filter", *this); }

double ShareMoved(const Pose2& odometry, const GraphFilterOptions& options) {
  return std::min(1.0, std::hypot(odometry.x, odometry.y) / options.position_sigma);
}

FilterAnswer UpdateBelief(const std::vector<Pose2>& poses,
                          const std::vector<NodeEvidence>& evidence, const FilterState& previous,
                          const std::optional<Pose2>& odometry, const GraphFilterOptions& options,
                          const std::vector<double>& heights) {
  options.Check();
  WS_CHECK(!poses.empty() && poses.size() == evidence.size(),
           std::to_string(evidence.size()) + " pieces of evidence for " +
               std::to_string(poses.size()) + " nodes");
  WS_CHECK(heights.empty() || heights.size() == poses.size(), "heights of some nodes alone");
  CheckPrevious(previous, poses.size());
  Update update(poses, evidence, heights, options);
  update.Move(previous, odometry);
  return update.Look();
}

}  // namespace waystone
