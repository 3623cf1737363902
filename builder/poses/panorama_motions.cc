// SPDX-License-Identifier: Apache-2.0
#include "builder/poses/panorama_motions.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/base/check.h"
#include "core/geometry/rotation.h"
#include "core/two_view/relative_rotation.h"
#include "localizer/index/node_bearings.h"
#include "localizer/index/spacing_parallax.h"
#include "schema/layers/poses/horizontal.h"

namespace waystone {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

// Fewer motions are inconclusive.
constexpr int kFewestMotions = 5;
// How far the nodes of a pair are from each other in their sequence: farther ones show more of a
// turn.
constexpr std::array<int, 2> kSpans = {1, 4};
// Without parallax a motion has no direction.
constexpr double kLeastParallax_rad = 0.02;
constexpr double kCompassSigmas = 3;

// How many of the compared ones agree.
struct Agreement {
  int agree = 0;
  int of = 0;

  void Count(bool agrees) {
    agree += agrees;
    ++of;
  }
  std::optional<double> Share() const {
    return of < kFewestMotions ? std::nullopt : std::optional(static_cast<double>(agree) / of);
  }
};

// The frame from above, with up estimated from these poses.
Horizontal SeenFromAbove(const GivenNodePoses& poses) {
  PoseLayer layer;
  for (const auto& pose : poses) {
    if (pose) layer.nodes.push_back(MakeNodePose({std::ssize(layer.nodes) + 1}, *pose));
  }
  return HorizontalOf(layer);
}

}  // namespace

PanoramaMotions::PanoramaMotions(const MapData& map, const GivenNodePoses& poses,
                                 const PoseOptions& options)
    : options_(options) {
  WS_CHECK(map.appearance.has_value(), "the map has no appearance layer");
  MatchFeatures(map, poses);
  TakeTurns(map, poses);
}

std::optional<double> PanoramaMotions::ConsistentShare(const GivenNodePoses& poses) const {
  const auto seen = ShareOfSeen(poses);
  return seen ? seen : ShareOfTurned(poses);
}

void PanoramaMotions::MatchFeatures(const MapData& map, const GivenNodePoses& poses) {
  const std::vector<AppearanceNode>& nodes = map.appearance->nodes;
  for (const int span : kSpans) {
    std::vector<Seen> pairs;
    for (int a = 0; a + span < std::ssize(nodes); ++a) {
      const int b = a + span;
      const bool comparable = poses[a] && poses[b] && nodes[a].sequence == nodes[b].sequence &&
                              !nodes[a].features.bearings.empty() &&
                              !nodes[b].features.bearings.empty();
      if (comparable) pairs.push_back({a, b, Matrix3d::Identity(), std::nullopt});
    }
    const size_t step = pairs.size() / static_cast<size_t>(options_.compared_steps) + 1;
    for (size_t i = 0; i < pairs.size(); i += step) seen_.push_back(pairs[i]);
  }
  const FeatureType type = map.info.feature_type;
  std::vector<char> found(seen_.size());
  tbb::parallel_for(size_t{0}, seen_.size(), [&](size_t i) {
    Seen& one = seen_[i];
    const MatchedRays rays = MatchBearings(ToBearingFeatures(nodes[one.a].features, type),
                                           ToBearingFeatures(nodes[one.b].features, type));
    const RelativePose pose = FindRelativePose(rays);
    found[i] = pose.accepted();
    one.b_from_a = pose.b_from_a;
    if (MedianParallax(rays, pose) >= kLeastParallax_rad) one.direction = pose.translation;
  });
  size_t kept = 0;
  for (size_t i = 0; i < seen_.size(); ++i) {
    if (found[i]) seen_[kept++] = seen_[i];
  }
  seen_.resize(kept);
}

void PanoramaMotions::TakeTurns(const MapData& map, const GivenNodePoses& poses) {
  std::map<AppearanceNodeId, int> at;
  for (const AppearanceNode& node : map.appearance->nodes) {
    at.emplace(node.id, static_cast<int>(at.size()));
  }
  for (const AppearanceEdge& edge : map.appearance->edges) {
    const int a = at.at(edge.a);
    const int b = at.at(edge.b);
    if (poses[a] && poses[b]) turned_.push_back({a, b, edge.a_from_b.theta_rad, edge.sigma_rad});
  }
}

std::optional<double> PanoramaMotions::ShareOfSeen(const GivenNodePoses& poses) const {
  Agreement all;
  Agreement turning;
  for (const Seen& one : seen_) {
    const Isometry3d given = poses[one.b]->inverse() * *poses[one.a];
    const bool turns = RotationAngle(given.linear(), one.b_from_a) <= options_.max_turn_error_rad;
    const bool goes = !one.direction || AngleBetween(given.translation(), *one.direction) <=
                                            options_.max_direction_error_rad;
    all.Count(turns && goes);
    const double turn = std::max(RotationAngle(given.linear(), Matrix3d::Identity()),
                                 RotationAngle(one.b_from_a, Matrix3d::Identity()));
    if (turn > 2 * options_.max_turn_error_rad) turning.Count(turns);
  }
  const auto share = all.Share();
  return share ? std::optional(std::min(*share, turning.Share().value_or(1))) : std::nullopt;
}

std::optional<double> PanoramaMotions::ShareOfTurned(const GivenNodePoses& poses) const {
  const Horizontal horizontal = SeenFromAbove(poses);
  Agreement turning;
  for (const Turned& one : turned_) {
    const double given = WrappedAngle(horizontal.Of(MakeCameraPose(*poses[one.b])).theta_rad -
                                      horizontal.Of(MakeCameraPose(*poses[one.a])).theta_rad);
    const double limit = std::max(options_.max_turn_error_rad, kCompassSigmas * one.sigma_rad);
    if (std::max(std::abs(given), std::abs(one.turn_rad)) <= 2 * limit) continue;
    turning.Count(std::abs(WrappedAngle(given - one.turn_rad)) <= limit);
  }
  return turning.Share();
}

}  // namespace waystone
