// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "core/base/angle.h"
#include "schema/layers/layer_problems.h"

namespace waystone {
namespace {

// How far a quaternion's norm may be from 1, and how much a covariance may break symmetry or have
// below 0, relative to its largest entry: rounding.
constexpr double kRounding = 1e-9;

bool IsAxis(int axis) { return axis == 0 || axis == 1; }

template <size_t n>
bool AreCounts(const std::array<int, n>& counts) {
  return std::all_of(counts.begin(), counts.end(), [](int count) { return count >= 0; });
}

bool IsRotation(const Eigen::Quaterniond& q) {
  return std::abs(q.norm() - 1) <= kRounding && q.w() >= 0;  // not for NaN
}

bool IsCovariance(const Eigen::Matrix3d& covariance) {
  if (!covariance.allFinite()) return false;
  const double allowed = kRounding * covariance.cwiseAbs().maxCoeff();
  if ((covariance - covariance.transpose()).cwiseAbs().maxCoeff() > allowed) return false;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().minCoeff() >= -allowed;
}

class OrientationProblemFinder {
 public:
  OrientationProblemFinder(const MapData& map, std::vector<MapProblem>& problems)
      : map_(map), layer_(*map.orientation), problems_(problems) {}

  void Find() {
    Require(layer_.step > 0, "orientation_layer 1", "its step is " + std::to_string(layer_.step));
    CheckAscending("orientation_frames", layer_.frames, [](const auto& frame) { return frame.id; });
    for (const OrientationFrame& frame : layer_.frames) CheckFrame(frame);
    const auto by_frame = [](const auto& item) { return item.frame; };
    CheckAscending("orientation_turns", layer_.turns, by_frame);
    for (const OrientationTurn& turn : layer_.turns) CheckTurn(turn);
    CheckAscending("orientation_nodes", layer_.nodes, by_frame);
    for (const OrientationNode& node : layer_.nodes) CheckNode(node);
    for (const OrientationFrameId turn : confirmed_) {
      Require(nodes_.contains(turn), Where("orientation_turns", turn), "it has no node");
    }
    CheckEdges();
    CheckCorridors();
  }

 private:
  void Require(bool holds, const std::string& where, const std::string& message) {
    if (!holds) problems_.push_back({where, message});
  }

  void RequireFrame(OrientationFrameId id, const std::string& where) {
    Require(frames_.contains(id), where,
            "there is no orientation frame " + std::to_string(id.value));
  }

  static std::string Where(const std::string& table, OrientationFrameId id) {
    return table + " " + std::to_string(id.value);
  }

  template <class Item, class IdOf>
  void CheckAscending(const std::string& table, const std::vector<Item>& items, IdOf id_of) {
    OrientationFrameId last;
    for (const Item& item : items) {
      Require(
          id_of(item) > last, Where(table, id_of(item)),
          "ids must be positive and increasing; the previous one is " + std::to_string(last.value));
      last = id_of(item);
    }
  }

  void CheckFrame(const OrientationFrame& frame) {
    const std::string where = Where("orientation_frames", frame.id);
    frames_.emplace(frame.id, frame.sequence);
    Require(HasSequence(map_, frame.sequence), where,
            "no such sequence: " + std::to_string(frame.sequence.value));
    const auto [last, first_of_sequence] = last_frame_.emplace(frame.sequence, -1);
    Require(frame.frame > last->second, where,
            "frame " + std::to_string(frame.frame) + " is below 0 or comes after frame " +
                std::to_string(last->second) + " of its sequence");
    last->second = frame.frame;
    Require(std::isfinite(frame.time_s.value_or(0)), where, "its time is not finite");
    Require(AreCounts(frame.lines), where, "negative number of lines");
    Require(frame.rotation || !frame.reliable, where, "it is reliable but has no rotation");
    if (!frame.rotation) return;
    Require(IsRotation(frame.rotation->building_from_rig), where,
            "its quaternion isn't of norm 1 with w of at least 0");
    Require(IsCovariance(frame.rotation->covariance), where,
            "its covariance isn't symmetric and positive semidefinite");
  }

  void CheckTurn(const OrientationTurn& turn) {
    const std::string where = Where("orientation_turns", turn.frame);
    RequireFrame(turn.frame, where);
    Require(turn.direction == 1 || turn.direction == -1, where,
            "its direction is " + std::to_string(turn.direction) +
                "; it must be 1 (left) or -1 (right)");
    Require(std::abs(turn.angle_rad) <= kPi, where,
            "its angle is " + std::to_string(turn.angle_rad) + " rad");
    Require(IsAxis(turn.axis_after), where, "its axis is " + std::to_string(turn.axis_after));
    if (turn.confirmed) confirmed_.insert(turn.frame);
  }

  void CheckNode(const OrientationNode& node) {
    const std::string where = Where("orientation_nodes", node.frame);
    nodes_.insert(node.frame);
    RequireFrame(node.frame, where);
    Require(AreCounts(node.directions), where, "a direction has a negative number of lines");
    Require((node.kind == OrientationNodeKind::kTurn) == confirmed_.contains(node.frame), where,
            "nodes of kind turn must match the confirmed turns");
  }

  void CheckEdges() {
    std::pair<OrientationFrameId, OrientationFrameId> last;
    for (const OrientationEdge& edge : layer_.edges) {
      const std::string where =
          Where("orientation_edges", edge.a) + "/" + std::to_string(edge.b.value);
      Require(edge.a < edge.b, where, "a must be below b");
      Require(std::pair(edge.a, edge.b) > last, where, "edges must be unique and sorted by (a, b)");
      last = {edge.a, edge.b};
      for (const OrientationFrameId node : {edge.a, edge.b}) {
        Require(nodes_.contains(node), where,
                "there is no orientation node " + std::to_string(node.value));
      }
      Require(edge.matches >= 0, where, std::to_string(edge.matches) + " matches");
    }
  }

  void CheckCorridors() {
    OrientationFrameId last;
    for (const Corridor& corridor : layer_.corridors) {
      const std::string where = Where("corridors", corridor.first);
      Require(corridor.first > last && corridor.first <= corridor.last, where,
              "corridors must be sorted, disjoint and end after they start");
      last = corridor.last;
      RequireFrame(corridor.first, where);
      RequireFrame(corridor.last, where);
      const auto first = frames_.find(corridor.first);
      const auto end = frames_.find(corridor.last);
      Require(first == frames_.end() || end == frames_.end() || first->second == end->second, where,
              "it starts and ends in different sequences");
      Require(IsAxis(corridor.axis), where, "its axis is " + std::to_string(corridor.axis));
    }
  }

  const MapData& map_;
  const OrientationLayer& layer_;
  std::vector<MapProblem>& problems_;
  std::unordered_map<OrientationFrameId, SequenceId> frames_;
  std::unordered_map<SequenceId, int> last_frame_;
  std::unordered_set<OrientationFrameId> confirmed_;
  std::unordered_set<OrientationFrameId> nodes_;
};

}  // namespace

void FindOrientationProblems(const MapData& map, std::vector<MapProblem>& problems) {
  OrientationProblemFinder(map, problems).Find();
}

}  // namespace waystone
