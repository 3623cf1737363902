// SPDX-License-Identifier: Apache-2.0
#include "builder/appearance/appearance_graph.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace waystone {
namespace {

// Relations that were measured, by the panoramas' indices.
using Relations = std::map<std::pair<int, int>, AppearanceEdge>;

class GraphMaker {
 public:
  GraphMaker(TakenPanoramas taken, const PanoramaPoses& poses, const AppearanceOptions& options)
      : taken_(std::move(taken)), poses_(poses), options_(options) {}

  AppearanceGraph Make() {
    MakeNodes();
    MakeEdges();
    HandOutSamples();
    graph_.layer.described = options_.describe.signature;
    graph_.layer.described.band = taken_.band;
    graph_.layer.mirror = taken_.mirror;
    return std::move(graph_);
  }

 private:
  void MakeNodes() {
    const std::vector<bool> keep =
        KeepInformative(taken_.signatures, poses_.poses, taken_.stretches, options_.redundancy);
    for (int i = 0; i < taken_.size(); ++i) {
      if (!keep[i]) continue;
      kept_.push_back(i);
      TakenFrame& frame = taken_.frames[i];
      AppearanceNode node;
      node.id = AppearanceNodeId{std::ssize(kept_)};
      node.sequence = taken_.sequences[taken_.StretchOf(i)];
      node.frame = frame.info.number;
      node.source = frame.info.source;
      node.time_s = frame.info.time_s;
      node.pose = poses_.poses[i];
      node.signature = frame.signature;
      node.picture = std::move(frame.picture);
      node.features = std::move(frame.kept);
      graph_.layer.nodes.push_back(std::move(node));
    }
    graph_.layer.dropped = taken_.size() - static_cast<int>(kept_.size());
  }

  void HandOutSamples() {
    for (TakenSample& sample : taken_.samples) {
      const int i = sample.panorama;
      const auto kept = std::lower_bound(kept_.begin(), kept_.end(), i);
      const bool is_node = kept != kept_.end() && *kept == i;
      graph_.samples.push_back({taken_.frames[i].signature, std::move(sample.features),
                                poses_.poses[i],
                                is_node ? static_cast<int>(kept - kept_.begin()) : -1,
                                taken_.sequences[taken_.StretchOf(i)], taken_.frames[i].info});
    }
  }

  // By the steps of the odometry between two panoramas of one sequence: a_from_b and its sigma.
  AppearanceEdge BySteps(int a, int b) const {
    AppearanceEdge edge;
    const size_t s = taken_.StretchOf(a);
    double variance = 0;
    for (int i = std::min(a, b); i < std::max(a, b); ++i) {
      const PanoramaRelation& step = poses_.trajectories[s].steps[i - taken_.stretches[s].first];
      edge.a_from_b = edge.a_from_b * step.a_from_b;
      variance += step.heading.sigma_rad * step.heading.sigma_rad;
    }
    if (a > b) edge.a_from_b = Inverse(edge.a_from_b);
    edge.sigma_rad = std::sqrt(variance);
    return edge;
  }

  // The index in kept_ of the nearest kept panorama of the same sequence.
  int NearestKept(int i) const {
    const auto after = std::lower_bound(kept_.begin(), kept_.end(), i);
    const int next = static_cast<int>(after - kept_.begin());
    if (*after == i || next == 0) return next;  // the ends of sequences are always kept
    return *after - i <= i - kept_[next - 1] ? next : next - 1;
  }

  void MakeEdges() {
    Relations edges;
    for (int k = 0; k + 1 < std::ssize(kept_); ++k) {
      if (taken_.StretchOf(kept_[k]) != taken_.StretchOf(kept_[k + 1])) continue;
      edges[{k, k + 1}] = BySteps(kept_[k], kept_[k + 1]);
    }
    for (const PanoramaRelation& loop : poses_.closure.loops) AddLoop(loop, edges);
    const auto& nodes = graph_.layer.nodes;
    for (auto& [ends, edge] : edges) {
      edge.a = nodes[ends.first].id;
      edge.b = nodes[ends.second].id;
      edge.distance = SignatureDistance(nodes[ends.first].signature, nodes[ends.second].signature,
                                        options_.odometry.k1);
      graph_.layer.edges.push_back(edge);
    }
  }

  // Loops of dropped panoramas are transferred to the kept ones next to them.
  void AddLoop(const PanoramaRelation& loop, Relations& edges) const {
    const int a = NearestKept(loop.a);
    const int b = NearestKept(loop.b);
    if (a >= b || edges.contains({a, b})) return;
    const AppearanceEdge to_a = BySteps(kept_[a], loop.a);
    const AppearanceEdge from_b = BySteps(loop.b, kept_[b]);
    AppearanceEdge edge;
    edge.kind = AppearanceEdgeKind::kLoop;
    edge.a_from_b = to_a.a_from_b * loop.a_from_b * from_b.a_from_b;
    edge.sigma_rad = std::hypot(to_a.sigma_rad, loop.heading.sigma_rad, from_b.sigma_rad);
    edges[{a, b}] = edge;
  }

  TakenPanoramas taken_;
  const PanoramaPoses& poses_;
  const AppearanceOptions& options_;
  std::vector<int> kept_;  // panoramas that became nodes
  AppearanceGraph graph_;
};

}  // namespace

AppearanceGraph MakeAppearanceGraph(TakenPanoramas taken, const PanoramaPoses& poses,
                                    const AppearanceOptions& options) {
  return GraphMaker(std::move(taken), poses, options).Make();
}

}  // namespace waystone
