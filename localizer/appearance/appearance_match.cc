// SPDX-License-Identifier: Apache-2.0
#include "localizer/appearance/appearance_match.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "core/geometry/linear_algebra.h"
#include "localizer/index/node_bearings.h"
#include "localizer/index/spacing_parallax.h"

namespace waystone {
namespace {

constexpr double kLeastDistance = 0.05;  // spacings: a node isn't nearer than this, for stability

const AppearanceNode& NodeAt(const MapIndex& index, int node) {
  return index.map().appearance->nodes[node];
}

Eigen::Vector2d PositionOf(const AppearanceNode& node) { return {node.pose.x, node.pose.y}; }

void RankByCost(std::vector<ComparedNode>& nodes) {
  std::ranges::sort(nodes, [](const ComparedNode& a, const ComparedNode& b) {
    return std::tie(a.cost, a.node) < std::tie(b.cost, b.node);
  });
}

// Ties, including all nodes without an accepted pose, stay in the order of appearance.
void RankByInliers(std::vector<ComparedNode>& nodes) {
  std::ranges::stable_sort(nodes, std::ranges::greater{}, &ComparedNode::inliers);
}

// Heading and direction of the query from the motion x_query = R x_node + t. Azimuths are clockwise
// and yaws counter-clockwise: what is in front of the node is at azimuth `heading` of the query.
void TakeMotion(const AppearanceNode& node, const MatchedRays& rays, const RelativePose& pose,
                ComparedNode& compared) {
  const Eigen::Matrix3d& r = pose.b_from_a;
  const Eigen::Vector3d query_in_node = -(r.transpose() * pose.translation);
  compared.inliers = static_cast<int>(pose.inliers.size());
  compared.query_from_node = r;
  compared.parallax_rad = MedianParallax(rays, pose);
  compared.heading_rad = WrappedAngle(node.pose.theta_rad + std::atan2(r(0, 2), r(2, 2)));
  compared.sigma_rad = std::sqrt(pose.covariance(1, 1));
  compared.direction_rad =
      WrappedAngle(node.pose.theta_rad - std::atan2(query_in_node.x(), query_in_node.z()));
}

struct Matched {
  size_t at = 0;  // in the compared nodes
  MatchedRays rays;
};

std::vector<Matched> MatchNodes(const MapIndex& index, const BearingFeatures& query,
                                const std::vector<ComparedNode>& nodes,
                                const PanoramaQueryOptions& options, const Deadline& deadline) {
  std::vector<Matched> matched;
  for (size_t at = 0; at < nodes.size() && !HasPassed(deadline); ++at) {
    const NodeFeatures& kept = NodeAt(index, nodes[at].node).features;
    if (kept.bearings.empty()) continue;
    matched.push_back(
        {at, MatchBearings(ToBearingFeatures(kept, query.type), query, options.match)});
  }
  std::ranges::stable_sort(matched, std::ranges::greater{},
                           [](const Matched& m) { return m.rays.size(); });
  return matched;
}

// The index of the best node that is elsewhere than nodes[at]; nodes.size() when there is none.
size_t BestElsewhere(const MapIndex& index, const std::vector<ComparedNode>& nodes, size_t at,
                     const PanoramaQueryOptions& options) {
  for (size_t other = 0; other < nodes.size(); ++other) {
    if (AreElsewhere(index, nodes[at].node, nodes[other].node, options)) return other;
  }
  return nodes.size();
}

}  // namespace

std::vector<ComparedNode> CompareByAppearance(const MapIndex& index, const FourierSignature& query,
                                              const PanoramaQueryOptions& options,
                                              const std::vector<bool>& left_out) {
  const int count = options.verify ? options.verified_candidates : options.candidates;
  std::vector<ComparedNode> nodes;
  for (const NearNode& near : index.appearance().Nearest(query, count, left_out)) {
    const AppearanceNode& node = NodeAt(index, near.node);
    const PhaseCompass turn = TurnByPhases(node.signature, query, options.phases);
    ComparedNode compared;
    compared.node = near.node;
    compared.cost = near.distance + options.phase_weight * (1 - turn.best.score);
    compared.heading_rad = WrappedAngle(node.pose.theta_rad + turn.best.heading_rad);
    compared.sigma_rad = options.phase_sigma_rad;
    nodes.push_back(compared);
  }
  RankByCost(nodes);
  return nodes;
}

std::vector<ComparedNode> VerifyByFeatures(const MapIndex& index, const BearingFeatures& query,
                                           std::vector<ComparedNode> nodes,
                                           const PanoramaQueryOptions& options,
                                           const Deadline& deadline) {
  int poses = 0;
  for (const Matched& matched : MatchNodes(index, query, nodes, options, deadline)) {
    if (poses++ == options.max_poses || HasPassed(deadline)) break;
    const RelativePose pose = FindRelativePose(matched.rays, options.relative);
    if (!pose.accepted()) continue;
    TakeMotion(NodeAt(index, nodes[matched.at].node), matched.rays, pose, nodes[matched.at]);
  }
  RankByInliers(nodes);
  return nodes;
}

std::vector<ComparedNode> CompareQuery(const MapIndex& index, const PanoramaQuery& query,
                                       const PanoramaQueryOptions& options,
                                       const std::vector<bool>& left_out) {
  PanoramaQueryOptions used = options;
  used.verify = query.features.has_value();
  std::vector<ComparedNode> nodes = CompareByAppearance(index, query.signature, used, left_out);
  if (!query.features) return nodes;
  return VerifyByFeatures(index, *query.features, std::move(nodes), options);
}

NodeRef RefOf(const MapIndex& index, const AppearanceNode& node) {
  const Sequence* sequence = index.FindSequence(node.sequence);
  return {node.id, sequence ? sequence->name : "", node.source, node.time_s, node.pose};
}

bool AreElsewhere(const MapIndex& index, int a, int b, const PanoramaQueryOptions& options) {
  const NodeDistances& nodes = index.appearance().distances();
  const double spacing = index.appearance().spacing();
  // Storeys may be lower than places are wide, so height is checked separately.
  return nodes.Between(a, b) > options.elsewhere_spacings * spacing ||
         nodes.Height(a, b) > kSameFloorSpacings * spacing;
}

namespace {

// log(1 + compared nodes beside nodes[at] that see the query's heading as it does).
double ComputeAgreement(const MapIndex& index, const std::vector<ComparedNode>& nodes, size_t at,
                        const PanoramaQueryOptions& options) {
  int agreeing = 0;
  for (size_t other = 0; other < nodes.size(); ++other) {
    if (other == at || AreElsewhere(index, nodes[at].node, nodes[other].node, options)) continue;
    const double off = WrappedAngle(nodes[other].heading_rad - nodes[at].heading_rad);
    agreeing += std::abs(off) <= options.agreement_rad;
  }
  return std::log1p(agreeing);
}

}  // namespace

AppearanceEvidence CollectEvidence(const MapIndex& index, const std::vector<ComparedNode>& nodes,
                                   size_t at, const PanoramaQueryOptions& options) {
  const size_t other = BestElsewhere(index, nodes, at, options);
  AppearanceEvidence evidence;
  evidence.cost = nodes[at].cost;
  evidence.margin = options.max_margin;
  evidence.agreement = ComputeAgreement(index, nodes, at, options);
  evidence.parallax_rad = nodes[at].parallax_rad;
  evidence.sigma_spacings =
      PlaceQuery(index, nodes, options, at).sigma / std::max(index.appearance().spacing(), 1e-9);
  evidence.log_inliers = evidence.log_inlier_margin = std::log1p(nodes[at].inliers);
  if (other == nodes.size()) return evidence;
  evidence.margin =
      std::clamp(nodes[other].cost - nodes[at].cost, -options.max_margin, options.max_margin);
  evidence.log_inlier_margin -= std::log1p(nodes[other].inliers);
  return evidence;
}

namespace {

// How far the query is from a node, in spacings: by the parallax where it was verified.
double EstimateDistance(const MapIndex& index, const ComparedNode& compared,
                        const ComparedNode& best, const PanoramaQueryOptions& options) {
  if (compared.inliers == 0) {
    return std::exp((compared.cost - best.cost) / options.interpolation_cost);
  }
  // A view with fewer inliers is farther away.
  const double fewer = static_cast<double>(best.inliers) / compared.inliers;
  return fewer * compared.parallax_rad / index.spacing_parallax_rad();
}

// Whether a node shows the same place as the best one and is verified exactly if that is.
bool Agrees(const MapIndex& index, const ComparedNode& best, const ComparedNode& compared,
            const PanoramaQueryOptions& options) {
  return !AreElsewhere(index, best.node, compared.node, options) &&
         (best.inliers > 0) == (compared.inliers > 0);
}

// The node that differs least from the query, by index in the layer.
int FindNearest(const MapIndex& index, const std::vector<ComparedNode>& nodes,
                const PanoramaQueryOptions& options, size_t at) {
  const ComparedNode& best = nodes[at];
  const auto distance = [&](const ComparedNode& compared) {
    return Agrees(index, best, compared, options) ? EstimateDistance(index, compared, best, options)
                                                  : std::numeric_limits<double>::infinity();
  };
  return std::ranges::min_element(nodes, {}, distance)->node;
}

}  // namespace

// Least squares over the position p: each node that agrees with the best one contributes "near me",
// and where its motion is known also "in this direction": n . (p - node) = 0 with n across the
// direction. The sigma of "near me" is the estimated distance, that of the direction the distance
// times the direction's sigma.
PlacedQuery PlaceQuery(const MapIndex& index, const std::vector<ComparedNode>& nodes,
                       const PanoramaQueryOptions& options, size_t at) {
  const ComparedNode& best = nodes[at];
  const double spacing = std::max(index.appearance().spacing(), 1e-9);
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  Eigen::Vector2d pull = Eigen::Vector2d::Zero();
  for (const ComparedNode& compared : nodes) {
    if (!Agrees(index, best, compared, options)) continue;
    const double distance =
        spacing * std::max(EstimateDistance(index, compared, best, options), kLeastDistance);
    const double near_weight = 1 / (distance * distance);
    Eigen::Matrix2d weights = near_weight * Eigen::Matrix2d::Identity();
    if (compared.inliers > 0) {
      const double across = options.direction_sigma_rad * std::max(distance, spacing);
      const Eigen::Vector2d n(-std::sin(compared.direction_rad), std::cos(compared.direction_rad));
      weights += n * n.transpose() * compared.inliers / (best.inliers * across * across);
    }
    information += weights;
    pull += weights * PositionOf(NodeAt(index, compared.node));
  }
  const Eigen::Vector2d position = SolveSymmetric(information, pull);
  PlacedQuery placed;
  placed.pose = {position.x(), position.y(), best.heading_rad};
  placed.covariance = information.inverse();
  placed.sigma = 1 / std::sqrt(DecomposeSymmetric(information).values(0));
  return placed;
}

void TakePlace(const MapIndex& index, const std::vector<ComparedNode>& nodes,
               const PanoramaQueryOptions& options, size_t at, PanoramaAnswer& panorama) {
  const PlacedQuery placed = PlaceQuery(index, nodes, options, at);
  panorama.node = RefOf(index, NodeAt(index, FindNearest(index, nodes, options, at)));
  panorama.pose = placed.pose;
  panorama.sigma = placed.sigma;
  panorama.covariance = placed.covariance;
}

}  // namespace waystone
