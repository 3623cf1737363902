// SPDX-License-Identifier: Apache-2.0
#include "builder/orientation/loops.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <utility>

#include "core/geometry/rotation.h"
#include "core/manhattan/cube_rotations.h"

namespace waystone {
namespace {

// The strongest features, equally many per camera; each camera's features are sorted, strongest
// first.
Descriptors SampleDescriptors(const BearingFeatures& features, int wanted) {
  Descriptors sample(DescriptorBytes(features.type));
  const int cameras = features.size() == 0 ? 1 : features.camera.back() + 1;
  const int share = (wanted + cameras - 1) / cameras;
  std::vector<int> taken(cameras, 0);
  for (int i = 0; i < features.size(); ++i) {
    if (taken[features.camera[i]]++ < share) sample.Append(features.descriptors.row(i));
  }
  return sample;
}

Eigen::Matrix3d RigFromBuilding(const OrientationFrame& frame) {
  return frame.rotation->building_from_rig.conjugate().toRotationMatrix();
}

bool MayClose(const OrientationFrame& a, const OrientationFrame& b,
              const OrientationLoopOptions& options) {
  if (!a.reliable || !b.reliable) return false;
  if (a.sequence != b.sequence) return true;
  if (std::abs(b.frame - a.frame) < options.min_gap_frames) return false;
  return RotationAngle(RigFromBuilding(a), RigFromBuilding(b)) <= options.max_turn_rad;
}

// Whether the orientation is the same by the features, independently of the numbering of axes.
bool Closes(const Traversal& traversal, const OrientationLoopOptions& options) {
  return traversal.connected && traversal.matches >= options.min_matches &&
         traversal.pose.log10_chance <= options.max_log10_chance &&
         traversal.disagreement_rad.value_or(1) <= options.max_disagreement_rad &&
         RotationAngle(traversal.pose.b_from_a, Eigen::Matrix3d::Identity()) <=
             options.max_turn_rad;
}

class LoopFinder {
 public:
  LoopFinder(std::span<const LoopNode> nodes, const OrientationLoopOptions& options,
             const TraversabilityOptions& traversability)
      : nodes_(nodes), options_(options), traversability_(traversability) {
    for (const LoopNode& node : nodes) {
      samples_.push_back(SampleDescriptors(*node.features.features, options.sample));
    }
  }

  // Loops from earlier nodes to this one.
  std::vector<OrientationEdge> To(size_t b) const {
    std::vector<OrientationEdge> edges;
    for (const size_t a : Candidates(b)) {
      const Traversal traversal =
          TestTraversability(nodes_[a].features, nodes_[b].features, traversability_);
      if (!Closes(traversal, options_)) continue;
      edges.push_back({.a = nodes_[a].features.frame->id,
                       .b = nodes_[b].features.frame->id,
                       .kind = OrientationEdgeKind::kLoop,
                       .matches = traversal.matches});
    }
    return edges;
  }

 private:
  std::vector<size_t> Candidates(size_t b) const {
    std::vector<std::pair<int, size_t>> ranked;  // matches, negative; node
    for (size_t a = 0; a < b; ++a) {
      if (nodes_[a].map >= 0 && nodes_[a].map == nodes_[b].map) continue;
      if (!MayClose(*nodes_[a].features.frame, *nodes_[b].features.frame, options_)) continue;
      const auto matches = MatchDescriptors(
          samples_[a], samples_[b], nodes_[b].features.features->type, traversability_.matching);
      ranked.emplace_back(-static_cast<int>(matches.size()), a);
    }
    std::ranges::sort(ranked);
    ranked.resize(std::min(ranked.size(), static_cast<size_t>(options_.candidates)));
    std::vector<size_t> best;
    for (const auto& [matches, a] : ranked) best.push_back(a);
    return best;
  }

  std::span<const LoopNode> nodes_;
  const OrientationLoopOptions& options_;
  const TraversabilityOptions& traversability_;
  std::vector<Descriptors> samples_;
};

}  // namespace

std::vector<OrientationEdge> FindLoops(std::span<const LoopNode> nodes,
                                       const OrientationLoopOptions& options,
                                       const TraversabilityOptions& traversability,
                                       ProgressReporter& progress) {
  const LoopFinder finder(nodes, options, traversability);
  std::vector<std::vector<OrientationEdge>> of_node(nodes.size());
  std::atomic<int> done = 0;
  tbb::parallel_for(size_t{0}, nodes.size(), [&](size_t b) {
    of_node[b] = finder.To(b);
    progress.Report("loops", ++done, static_cast<int>(nodes.size()));
  });
  std::vector<OrientationEdge> edges;
  for (const auto& some : of_node) edges.insert(edges.end(), some.begin(), some.end());
  std::ranges::sort(edges, {}, [](const OrientationEdge& e) { return std::pair(e.a, e.b); });
  return edges;
}

}  // namespace waystone
