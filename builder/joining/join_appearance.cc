// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/join_appearance.h"

#include <algorithm>
#include <boost/pending/disjoint_sets.hpp>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "builder/appearance/visual_odometry.h"
#include "builder/joining/align_layers.h"
#include "builder/joining/joinable.h"
#include "core/base/error.h"
#include "localizer/index/appearance_index.h"

namespace waystone {
namespace {

constexpr double kGapSpacings = 5;       // between what nothing ties together
constexpr double kLeastSpacings = 0.02;  // no position is surer
constexpr double kLeastSigma_rad = 0.005;
constexpr size_t kNone = static_cast<size_t>(-1);

// Panoramas of one map that its edges join, or all of them where they have poses: at first they
// move as a unit.
struct Unit {
  size_t map = 0;
  std::vector<size_t> nodes;
  std::optional<LayerChange> placed = {};
  size_t root = kNone;  // the unit in whose layer it was placed
};

// One map's answer to another map's panorama; both by their indices among all nodes.
struct Tie {
  size_t found = 0;
  size_t asking = 0;
  Pose2 pose;  // of the asking one, in the layer of the found one
  double position_sigma = 0;
  double heading_sigma_rad = 0;
};

class LayerJoiner {
 public:
  LayerJoiner(const AppearanceOptions& options, std::vector<MapData>& maps)
      : options_(options), maps_(maps) {
    for (size_t m = 0; m < maps.size(); ++m) {
      firsts_.push_back(nodes_.size());
      if (!maps[m].appearance) continue;
      if (first_map_ == kNone) {
        first_map_ = m;
        const PoseLayer* poses = maps[m].poses ? &*maps[m].poses : nullptr;
        spacing_ = AppearanceIndex(*maps[m].appearance, {}, poses).spacing();
      }
      for (size_t n = 0; n < maps[m].appearance->nodes.size(); ++n) nodes_.emplace_back(m, n);
    }
    any_posed_ = std::ranges::any_of(maps, [](const MapData& map) { return IsPosed(map); });
    FindUnits();
  }

  std::vector<NodeTie> Join(const std::vector<Recognition>& recognitions) {
    CollectTies(recognitions);
    Place();
    LayOut();
    const std::vector<bool> rejected = Optimise();
    WriteBack();
    return TiesThatFit(rejected);
  }

 private:
  static bool IsPosed(const MapData& map) { return map.poses && !map.poses->nodes.empty(); }

  AppearanceNode& NodeAt(size_t i) const {
    return maps_[nodes_[i].first].appearance->nodes[nodes_[i].second];
  }
  size_t IndexOf(size_t map, AppearanceNodeId id) const {
    const auto& nodes = maps_[map].appearance->nodes;
    const auto at = std::ranges::lower_bound(nodes, id, {}, &AppearanceNode::id);
    return firsts_[map] + static_cast<size_t>(at - nodes.begin());
  }

  void FindUnits() {
    boost::disjoint_sets_with_storage<> sets(nodes_.size());
    for (size_t m = 0; m < maps_.size(); ++m) {
      if (!maps_[m].appearance) continue;
      for (const AppearanceEdge& edge : maps_[m].appearance->edges) {
        sets.union_set(IndexOf(m, edge.a), IndexOf(m, edge.b));
      }
      const size_t count = IsPosed(maps_[m]) ? maps_[m].appearance->nodes.size() : 0;
      for (size_t n = 1; n < count; ++n) sets.union_set(firsts_[m], firsts_[m] + n);
    }
    std::map<size_t, size_t> unit_of_set;
    for (size_t i = 0; i < nodes_.size(); ++i) {
      const auto [unit, is_new] = unit_of_set.emplace(sets.find_set(i), units_.size());
      if (is_new) units_.push_back({nodes_[i].first, {}});
      units_[unit->second].nodes.push_back(i);
      unit_of_.push_back(unit->second);
    }
  }

  void CollectTies(const std::vector<Recognition>& recognitions) {
    for (const Recognition& recognition : recognitions) {
      for (const RecognisedNode& one : recognition.nodes) {
        ties_.push_back({firsts_[recognition.asked] + one.found,
                         firsts_[recognition.asking] + one.asking, one.pose, one.position_sigma,
                         one.heading_sigma_rad});
      }
    }
  }

  // The panoramas that ties place in the layers of both units.
  std::vector<PoseInLayers> Common(size_t to, size_t from) const {
    std::vector<PoseInLayers> common;
    for (const Tie& tie : ties_) {
      const Pose2& own = NodeAt(tie.asking).pose;
      if (unit_of_[tie.found] == to && unit_of_[tie.asking] == from) {
        common.push_back({tie.pose, own, tie.position_sigma, false});
      } else if (unit_of_[tie.found] == from && unit_of_[tie.asking] == to) {
        common.push_back({own, tie.pose, tie.position_sigma, true});
      }
    }
    return common;
  }

  bool HaveOneUnit(size_t a, size_t b) const {
    const auto scale_of = [&](size_t unit) {
      return maps_[units_[unit].map].appearance->metres_per_unit;
    };
    return scale_of(a) && scale_of(a) == scale_of(b);
  }

  // Places the unit with the most ties to those already placed; false where no unit has any.
  bool PlaceNext() {
    std::vector<std::pair<std::ptrdiff_t, std::pair<size_t, size_t>>> pairs;  // ties, negative
    for (size_t to = 0; to < units_.size(); ++to) {
      for (size_t from = 0; from < units_.size(); ++from) {
        if (!units_[to].placed || units_[from].placed || tried_.contains({to, from})) continue;
        const auto ties = tie_count_.find(std::minmax(to, from));
        if (ties != tie_count_.end()) pairs.push_back({-ties->second, {to, from}});
      }
    }
    std::ranges::sort(pairs);
    for (const auto& [ties, pair] : pairs) {
      tried_.insert(pair);
      const auto [to, from] = pair;
      const auto change = AlignLayers(Common(to, from), HaveOneUnit(to, from));
      if (!change) continue;
      const LayerChange& above = *units_[to].placed;
      units_[from].placed = {above.scale * change->scale, above(change->to_from)};
      units_[from].root = units_[to].root;
      return true;
    }
    return false;
  }

  void Place() {
    for (const Tie& tie : ties_) {
      const size_t a = unit_of_[tie.found];
      const size_t b = unit_of_[tie.asking];
      if (a != b) ++tie_count_[std::minmax(a, b)];
    }
    size_t root = kNone;  // of all with poses, whose layers are of one frame
    for (size_t u = 0; u < units_.size(); ++u) {
      if (!IsPosed(maps_[units_[u].map])) continue;
      if (root == kNone) root = u;
      units_[u].placed = LayerChange{};
      units_[u].root = root;
    }
    for (size_t u = 0; u < units_.size(); ++u) {
      while (PlaceNext()) {
      }
      if (units_[u].placed) continue;
      if (any_posed_) RefuseUnplaced(units_[u]);
      units_[u].placed = LayerChange{};
      units_[u].root = u;
    }
    while (PlaceNext()) {
    }
  }

  [[noreturn]] void RefuseUnplaced(const Unit& unit) const {
    throw MapError(ErrorCode::kBadRequest,
                   Named(maps_[unit.map]) + " has " + std::to_string(unit.nodes.size()) +
                       " panoramas without poses, of which too few show places of the maps with "
                       "poses (3 at least, and half of those that are recognised, must agree); "
                       "build it with --poses, or the others without");
  }

  // Puts what isn't tied to the first map's panoramas below everything else.
  void LayOut() {
    for (size_t i = 0; i < nodes_.size(); ++i) placed_.push_back(Start(i));
    double lowest = 0;
    std::map<size_t, std::vector<size_t>> below;  // nodes by the root of their unit
    for (size_t i = 0; i < nodes_.size(); ++i) {
      const size_t root = units_[unit_of_[i]].root;
      const bool stays = any_posed_ || units_[root].map == first_map_;
      if (stays) lowest = std::min(lowest, placed_[i].y);
      if (!stays) below[root].push_back(i);
    }
    for (const auto& [root, nodes] : below) {
      double top = placed_[nodes.front()].y;
      for (const size_t i : nodes) top = std::max(top, placed_[i].y);
      const double down = lowest - kGapSpacings * spacing_ - top;
      for (const size_t i : nodes) {
        placed_[i].y += down;
        lowest = std::min(lowest, placed_[i].y);
      }
    }
  }

  Pose2 Start(size_t i) const { return (*units_[unit_of_[i]].placed)(NodeAt(i).pose); }

  // Lengths of maps other than the first are measured in units of their own.
  int ScaleGroup(size_t map) const {
    return map == first_map_ || IsPosed(maps_[map]) || maps_[map].appearance->metres_per_unit
               ? 0
               : static_cast<int>(map);
  }

  // The layers as they are, with the flexibility of steps, and the ties.
  std::vector<PoseEdge> EdgesOfGraph() const {
    std::vector<PoseEdge> edges;
    const double least = std::max(kLeastSpacings * spacing_, 1e-9);
    for (size_t m = 0; m < maps_.size(); ++m) {
      if (!maps_[m].appearance) continue;
      for (const AppearanceEdge& one : maps_[m].appearance->edges) {
        const size_t a = IndexOf(m, one.a);
        const size_t b = IndexOf(m, one.b);
        PoseEdge edge{static_cast<int>(a), static_cast<int>(b), Inverse(placed_[a]) * placed_[b]};
        const double length = std::hypot(edge.a_from_b.x, edge.a_from_b.y);
        edge.position_sigma =
            IsPosed(maps_[m]) ? least : std::max(least, options_.odometry.length_sigma * length);
        edge.heading_sigma_rad =
            IsPosed(maps_[m]) ? kLeastSigma_rad : std::max(kLeastSigma_rad, one.sigma_rad);
        edge.scale_group = ScaleGroup(m);
        edges.push_back(edge);
      }
    }
    for (const Tie& tie : ties_) {
      const double scale = units_[unit_of_[tie.found]].placed->scale;
      PoseEdge edge{static_cast<int>(tie.found), static_cast<int>(tie.asking), RelativeOf(tie)};
      edge.a_from_b.x *= scale;
      edge.a_from_b.y *= scale;
      edge.position_sigma = std::max(least, scale * tie.position_sigma);
      edge.heading_sigma_rad = std::max(kLeastSigma_rad, tie.heading_sigma_rad);
      edge.loop = true;
      edge.scale_group = ScaleGroup(nodes_[tie.found].first);
      edges.push_back(edge);
    }
    return edges;
  }

  // found_from_asking, in the unit of the found one's layer.
  Pose2 RelativeOf(const Tie& tie) const { return Inverse(NodeAt(tie.found).pose) * tie.pose; }

  // Optimises all poses; returns for each tie whether it was rejected.
  std::vector<bool> Optimise() {
    // Ties between parts that stayed apart carry no information.
    std::erase_if(ties_, [&](const Tie& tie) {
      return units_[unit_of_[tie.found]].root != units_[unit_of_[tie.asking]].root;
    });
    scales_.assign(maps_.size(), 1);
    if (ties_.empty()) return {};
    const std::vector<PoseEdge> edges = EdgesOfGraph();
    const PoseGraphResult result = OptimisePoseGraph(placed_, edges, options_.graph);
    for (size_t i = 0; i < nodes_.size(); ++i) {
      if (!IsPosed(maps_[nodes_[i].first])) placed_[i] = result.poses[i];
    }
    for (size_t m = 0; m < maps_.size(); ++m) {
      if (!maps_[m].appearance) continue;
      const auto group = static_cast<size_t>(ScaleGroup(m));
      if (group < result.scales.size()) scales_[m] = result.scales[group];
    }
    return {result.rejected.end() - std::ssize(ties_), result.rejected.end()};
  }

  // The factor from lengths of a node's layer to those of the joined one.
  double ScaleOf(size_t node) const {
    return units_[unit_of_[node]].placed->scale * scales_[nodes_[node].first];
  }

  void WriteBack() {
    relative_.clear();
    for (const Tie& tie : ties_) {
      Pose2 relative = RelativeOf(tie);
      relative.x *= ScaleOf(tie.found);
      relative.y *= ScaleOf(tie.found);
      relative_.push_back(relative);
    }
    for (size_t m = 0; m < maps_.size(); ++m) {
      if (!maps_[m].appearance) continue;
      for (AppearanceEdge& edge : maps_[m].appearance->edges) {
        const double scale = ScaleOf(IndexOf(m, edge.a));
        edge.a_from_b.x *= scale;
        edge.a_from_b.y *= scale;
      }
      if (!maps_[m].poses) MoveAreas(m);
    }
    const auto posed = std::ranges::find_if(maps_, [](const MapData& map) { return IsPosed(map); });
    for (MapData& map : maps_) {
      if (!map.appearance || posed == maps_.end()) continue;
      map.appearance->metres_per_unit = posed->appearance->metres_per_unit;
    }
    for (size_t i = 0; i < nodes_.size(); ++i) {
      NodeAt(i).pose = placed_[i];
      NodeAt(i).pose.theta_rad = WrappedAngle(placed_[i].theta_rad);
    }
  }

  // Areas move like the largest unit of their map.
  void MoveAreas(size_t map) {
    if (maps_[map].appearance->nodes.empty()) return;
    const Unit* largest = nullptr;
    for (const Unit& unit : units_) {
      if (unit.map != map) continue;
      if (largest == nullptr || unit.nodes.size() > largest->nodes.size()) largest = &unit;
    }
    const size_t node = largest->nodes.front();
    // Includes what the layout and the optimisation did to one of its panoramas.
    const Pose2 moved = placed_[node] * Inverse(Start(node));
    for (NamedPlace& place : maps_[map].names) {
      for (NamedPolygon& polygon : place.polygons) {
        for (Eigen::Vector2d& corner : polygon) {
          const Pose2 at = moved * (*largest->placed)(Pose2{corner.x(), corner.y(), 0});
          corner = {at.x, at.y};
        }
      }
    }
  }

  std::vector<NodeTie> TiesThatFit(const std::vector<bool>& rejected) const {
    std::map<std::pair<size_t, size_t>, size_t> surest;  // tie by its nodes
    for (size_t t = 0; t < ties_.size(); ++t) {
      if (rejected[t]) continue;
      const auto [known, is_new] = surest.emplace(std::minmax(ties_[t].found, ties_[t].asking), t);
      if (!is_new && ties_[t].position_sigma < ties_[known->second].position_sigma) {
        known->second = t;
      }
    }
    std::vector<NodeTie> fitting;
    for (const auto& [nodes, t] : surest) {
      const auto [a, b] = nodes;
      NodeTie tie{nodes_[a].first, nodes_[a].second, nodes_[b].first, nodes_[b].second, {}};
      tie.edge.kind = AppearanceEdgeKind::kLoop;
      tie.edge.a_from_b = ties_[t].found == a ? relative_[t] : Inverse(relative_[t]);
      tie.edge.sigma_rad = ties_[t].heading_sigma_rad;
      tie.edge.distance =
          SignatureDistance(NodeAt(a).signature, NodeAt(b).signature, options_.odometry.k1);
      fitting.push_back(tie);
    }
    return fitting;
  }

  const AppearanceOptions& options_;
  std::vector<MapData>& maps_;
  bool any_posed_ = false;
  size_t first_map_ = kNone;                      // with an appearance layer
  double spacing_ = 0;                            // of its nodes
  std::vector<size_t> firsts_;                    // node of each map
  std::vector<std::pair<size_t, size_t>> nodes_;  // map and place in it
  std::vector<Unit> units_;
  std::vector<size_t> unit_of_;
  std::vector<Tie> ties_;
  std::map<std::pair<size_t, size_t>, std::ptrdiff_t> tie_count_;  // of two units
  std::set<std::pair<size_t, size_t>> tried_;
  std::vector<Pose2> placed_;    // of each node
  std::vector<double> scales_;   // of each map, by the optimisation
  std::vector<Pose2> relative_;  // of each tie, found_from_asking in the joined layer's unit
};

}  // namespace

std::vector<NodeTie> JoinAppearance(const std::vector<Recognition>& recognitions,
                                    const AppearanceOptions& options, std::vector<MapData>& maps) {
  const auto layers =
      std::ranges::count_if(maps, [](const MapData& map) { return map.appearance.has_value(); });
  if (layers < 2) return {};
  return LayerJoiner(options, maps).Join(recognitions);
}

void AddTies(const std::vector<NodeTie>& ties, const std::vector<size_t>& firsts, MapData& map) {
  if (ties.empty()) return;
  AppearanceLayer& layer = *map.appearance;
  for (const NodeTie& tie : ties) {
    AppearanceEdge edge = tie.edge;
    edge.a = layer.nodes[firsts[tie.map_a] + tie.node_a].id;
    edge.b = layer.nodes[firsts[tie.map_b] + tie.node_b].id;
    layer.edges.push_back(edge);
  }
  std::ranges::sort(layer.edges, {}, [](const AppearanceEdge& e) { return std::pair(e.a, e.b); });
}

}  // namespace waystone
