// SPDX-License-Identifier: Apache-2.0
#include "builder/poses/add_node_poses.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "builder/poses/misreadings.h"
#include "builder/poses/panorama_motions.h"
#include "core/base/error.h"
#include "core/robust/median.h"
#include "schema/layers/poses/horizontal.h"

namespace waystone {
namespace {

using Eigen::Isometry3d;

Pose2 Stretched(const Pose2& pose, double scale) {
  return {scale * pose.x, scale * pose.y, pose.theta_rad};
}

const Sequence& SequenceOf(const MapData& map, SequenceId id) {
  return *std::ranges::lower_bound(map.sequences, id, {}, &Sequence::id);
}

GivenNodePoses CollectPoses(const MapData& map, const GivenPoses& given) {
  GivenNodePoses poses;
  for (const AppearanceNode& node : map.appearance->nodes) {
    poses.push_back(
        given.of_image(SequenceOf(map, node.sequence), {node.frame, node.source, node.time_s}));
  }
  return poses;
}

void RequireNodePoses(const NodePoseReport& report, double min_posed) {
  if (report.posed >= min_posed * report.nodes && report.posed > 0) return;
  throw MapError(ErrorCode::kBadRequest,
                 "only " + std::to_string(report.posed) + " of " + std::to_string(report.nodes) +
                     " panoramas have a pose (first without: " + report.first_without +
                     "); check that the poses are of these images, by name or time");
}

std::optional<double> RequireAgreement(const MapData& map, const GivenNodePoses& poses,
                                       const PoseOptions& options) {
  const PanoramaMotions motions(map, poses, options);
  const std::optional<double> share = motions.ConsistentShare(poses);
  if (!share || *share >= options.min_consistent) return share;
  const auto share_of = [&](const PoseReading& read) {
    GivenNodePoses corrected = poses;
    for (auto& pose : corrected) {
      if (pose) pose = read(*pose);
    }
    return motions.ConsistentShare(corrected).value_or(0);
  };
  throw MapError(ErrorCode::kBadRequest,
                 "the poses contradict the panoramas: only " + SharePercent(*share) +
                     " of the motions from one to the next agree with them; " +
                     RemedyFor(share_of, std::max(options.min_consistent, 2 * *share)));
}

// The positions of nodes after those with poses have been moved into the frame.
class NodeMover {
 public:
  NodeMover(const std::vector<AppearanceNode>& nodes, const GivenNodePoses& poses,
            const Horizontal& horizontal)
      : nodes_(nodes) {
    for (const auto& pose : poses) {
      above_.push_back(pose ? std::optional(horizontal.Of(MakeCameraPose(*pose))) : std::nullopt);
    }
    scale_ = FindScale();
  }

  // How many units of the frame one former unit of the layer is.
  double scale() const { return scale_; }

  std::vector<Pose2> Move() const {
    std::vector<Pose2> moved;
    for (int i = 0; i < std::ssize(nodes_); ++i) moved.push_back(above_[i] ? *above_[i] : Fill(i));
    return moved;
  }

 private:
  // The median over steps between nodes with poses: drift of the layer's trajectory doesn't count.
  double FindScale() const {
    std::vector<double> ratios;
    int last = -1;
    for (int i = 0; i < std::ssize(nodes_); ++i) {
      if (!above_[i]) continue;
      if (last >= 0 && nodes_[last].sequence == nodes_[i].sequence) {
        const double before = Apart(nodes_[last].pose, nodes_[i].pose);
        const double after = Apart(*above_[last], *above_[i]);
        if (before > 0 && after > 0) ratios.push_back(after / before);
      }
      last = i;
    }
    return ratios.empty() ? 1 : Median(std::move(ratios));
  }

  bool IsAnchor(int i, int of) const {
    return i >= 0 && i < std::ssize(nodes_) && nodes_[i].sequence == nodes_[of].sequence;
  }

  // The pose that the layer's own motion from a node with a pose leads to.
  Pose2 From(int anchor, int i) const {
    return *above_[anchor] * Stretched(Inverse(nodes_[anchor].pose) * nodes_[i].pose, scale_);
  }

  // Between the nodes with poses before and after, or from the only one of its sequence, or from
  // the nearest of all.
  Pose2 Fill(int i) const {
    int before = i;
    while (IsAnchor(before, i) && !above_[before]) --before;
    int after = i;
    while (IsAnchor(after, i) && !above_[after]) ++after;
    if (!IsAnchor(before, i) && !IsAnchor(after, i)) return From(Nearest(i), i);
    if (!IsAnchor(after, i)) return From(before, i);
    if (!IsAnchor(before, i)) return From(after, i);
    const Pose2 a = From(before, i);
    const Pose2 b = From(after, i);
    const double share = static_cast<double>(i - before) / (after - before);
    return {a.x + share * (b.x - a.x), a.y + share * (b.y - a.y),
            WrappedAngle(a.theta_rad + share * WrappedAngle(b.theta_rad - a.theta_rad))};
  }

  int Nearest(int i) const {
    int nearest = -1;
    double least = std::numeric_limits<double>::infinity();
    for (int other = 0; other < std::ssize(nodes_); ++other) {
      const double apart = Apart(nodes_[other].pose, nodes_[i].pose);
      if (!above_[other] || apart >= least) continue;
      least = apart;
      nearest = other;
    }
    return nearest;
  }

  const std::vector<AppearanceNode>& nodes_;
  std::vector<std::optional<Pose2>> above_;
  double scale_ = 1;
};

// A sample that was left out of the layer has its own pose; without one it is useless.
void MoveSamples(const MapData& map, const GivenPoses& poses, const Horizontal& horizontal,
                 std::vector<AppearanceSampleFrame>& samples) {
  std::erase_if(samples, [&](AppearanceSampleFrame& sample) {
    if (sample.node >= 0) {
      sample.pose = map.appearance->nodes[sample.node].pose;
      return false;
    }
    const auto pose = poses.of_image(SequenceOf(map, sample.sequence), sample.info);
    if (pose) sample.pose = horizontal.Of(MakeCameraPose(*pose));
    return !pose;
  });
}

}  // namespace

NodePoseReport AddNodePoses(const GivenPoses& given, const PoseOptions& options, MapData& map,
                            std::vector<AppearanceSampleFrame>& samples) {
  AppearanceLayer& appearance = *map.appearance;
  const GivenNodePoses poses = CollectPoses(map, given);
  NodePoseReport report;
  report.nodes = static_cast<int>(poses.size());
  for (size_t i = 0; i < poses.size(); ++i) {
    report.posed += poses[i].has_value();
    if (!poses[i] && report.first_without.empty()) {
      report.first_without = appearance.nodes[i].source;
    }
  }
  if (report.posed == 0 && map.poses) return report;
  RequireNodePoses(report, options.min_posed);
  report.consistent = RequireAgreement(map, poses, options);
  if (!map.poses) {
    map.poses.emplace();
    map.poses->frame = given.frame;
    map.poses->unit = given.unit;
  }
  for (size_t i = 0; i < poses.size(); ++i) {
    if (poses[i]) map.poses->nodes.push_back(MakeNodePose(appearance.nodes[i].id, *poses[i]));
  }
  const Horizontal horizontal = HorizontalOf(*map.poses);
  const NodeMover mover(appearance.nodes, poses, horizontal);
  const std::vector<Pose2> moved = mover.Move();
  for (size_t i = 0; i < moved.size(); ++i) appearance.nodes[i].pose = moved[i];
  for (AppearanceEdge& edge : appearance.edges) {
    edge.a_from_b = Stretched(edge.a_from_b, mover.scale());
  }
  appearance.metres_per_unit.reset();
  if (given.unit == LengthUnit::kMetres) appearance.metres_per_unit = 1;
  MoveSamples(map, given, horizontal, samples);
  return report;
}

}  // namespace waystone
