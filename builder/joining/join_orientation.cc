// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/join_orientation.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <boost/pending/disjoint_sets.hpp>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "builder/orientation/loops.h"
#include "core/base/error.h"
#include "core/camera/image_plane.h"
#include "core/camera/rig.h"
#include "core/geometry/angle.h"
#include "core/geometry/rotation.h"
#include "core/image/decode.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;

// How far the relation of two sequences' axes may be from a multiple of a quarter turn; otherwise
// it is ignored.
constexpr double kMaxOff_rad = 0.2;

Matrix3d QuarterTurns(int turns) {
  constexpr std::array<int, 4> kCosines{1, 0, -1, 0};
  constexpr std::array<int, 4> kSines{0, 1, 0, -1};
  Matrix3d rotation = Matrix3d::Identity();
  rotation.topLeftCorner<2, 2>() << kCosines[turns], -kSines[turns], kSines[turns], kCosines[turns];
  return rotation;
}

// The camera that a node's picture was taken by: that of its sequence, or the front face of a rig
// that sees all around.
std::optional<Camera> CameraOfPicture(const Sequence& sequence, const cv::Size& size) {
  if (sequence.camera && sequence.camera->model != CameraModel::kEquirectangular) {
    const Camera camera = ScaledCamera(*sequence.camera, size.width);
    if (camera.width == size.width && camera.height == size.height) return camera;
    return std::nullopt;
  }
  if (size.width != size.height) return std::nullopt;
  return CubeRig(size.width).cameras.front().camera;
}

// The features of a node's picture; none where it has none that can be used.
BearingFeatures FeaturesOfNode(const OrientationNode& node, const Sequence& sequence,
                               const BearingFeatureOptions& options) {
  BearingFeatures none;
  none.type = options.features.type;
  none.descriptors = Descriptors(DescriptorBytes(none.type));
  if (node.picture.empty()) return none;
  try {
    const cv::Mat picture = DecodeGrey(node.picture);
    const std::optional<Camera> camera = CameraOfPicture(sequence, picture.size());
    if (!camera) return none;
    return ExtractBearings(RigOfOne(*camera), std::vector<cv::Mat>{picture}, options);
  } catch (const MapError&) {
    return none;
  }
}

// The number of quarter turns that take b's axes to a's, by a motion between two frames; nothing
// where the axes aren't reliable or the motion fits no quarter turn.
std::optional<int> QuarterTurnsBetween(const OrientationFrame& a, const OrientationFrame& b,
                                       const Matrix3d& b_from_a) {
  if (!a.reliable || !b.reliable) return std::nullopt;
  const Matrix3d a_from_b = a.rotation->building_from_rig.toRotationMatrix() *
                            b_from_a.transpose() *
                            b.rotation->building_from_rig.conjugate().toRotationMatrix();
  const double yaw = std::atan2(a_from_b(1, 0) - a_from_b(0, 1), a_from_b(0, 0) + a_from_b(1, 1));
  const int turns = static_cast<int>(std::lround(yaw / kQuarterTurn_rad) + 4) % 4;
  if (RotationAngle(a_from_b, QuarterTurns(turns)) > kMaxOff_rad) return std::nullopt;
  return turns;
}

// Evidence about two sequences' axes: inliers for each number of quarter turns.
using Votes = std::map<std::pair<SequenceId, SequenceId>, std::array<int64_t, 4>>;

class OrientationJoiner {
 public:
  OrientationJoiner(const std::vector<SequenceId>& maps, const OrientationOptions& options,
                    MapData& map)
      : maps_(maps), options_(options), map_(map), layer_(*map.orientation) {}

  OrientationJoin Join(const std::vector<Recognition>& recognitions,
                       const std::vector<size_t>& firsts) {
    MakeGroups();
    FindLoopsBetweenMaps();
    VoteByPanoramas(recognitions, firsts);
    TurnGroups();
    const auto key = [](const OrientationEdge& edge) { return std::pair(edge.a, edge.b); };
    layer_.edges.insert(layer_.edges.end(), loops_.begin(), loops_.end());
    std::ranges::sort(layer_.edges, {}, key);
    return result_;
  }

 private:
  int MapOf(SequenceId sequence) const {
    return static_cast<int>(std::ranges::upper_bound(maps_, sequence) - maps_.begin());
  }
  const Sequence& SequenceOf(SequenceId id) const {
    return *std::ranges::lower_bound(map_.sequences, id, {}, &Sequence::id);
  }
  const OrientationFrame& FrameOf(OrientationFrameId id) const {
    return *std::ranges::lower_bound(layer_.frames, id, {}, &OrientationFrame::id);
  }
  const OrientationFrame* FindFrame(SequenceId sequence, int frame) const {
    const auto found = frames_.find({sequence, frame});
    return found == frames_.end() ? nullptr : found->second;
  }

  // Sequences that edges of their maps join have the same axes.
  void MakeGroups() {
    std::map<SequenceId, size_t> number;
    for (const OrientationFrame& frame : layer_.frames) {
      number.emplace(frame.sequence, number.size());
      frames_[{frame.sequence, frame.frame}] = &frame;
    }
    boost::disjoint_sets_with_storage<> sets(number.size());
    for (const OrientationEdge& edge : layer_.edges) {
      sets.union_set(number.at(FrameOf(edge.a).sequence), number.at(FrameOf(edge.b).sequence));
    }
    std::map<size_t, SequenceId> first;  // of each set
    for (const auto& [id, i] : number) {
      group_of_[id] = first.emplace(sets.find_set(i), id).first->second;
    }
  }

  void Vote(const OrientationFrame& a, const OrientationFrame& b, const Matrix3d& b_from_a,
            int inliers) {
    const auto turns = QuarterTurnsBetween(a, b, b_from_a);
    if (!turns) return;
    votes_[{group_of_.at(a.sequence), group_of_.at(b.sequence)}][*turns] += inliers;
    votes_[{group_of_.at(b.sequence), group_of_.at(a.sequence)}][(4 - *turns) % 4] += inliers;
  }

  void FindLoopsBetweenMaps() {
    const size_t count = layer_.nodes.size();
    std::vector<BearingFeatures> features(count);
    tbb::parallel_for(size_t{0}, count, [&](size_t i) {
      const OrientationNode& node = layer_.nodes[i];
      features[i] =
          FeaturesOfNode(node, SequenceOf(FrameOf(node.frame).sequence), options_.bearings);
    });
    std::vector<LoopNode> nodes;
    std::map<OrientationFrameId, size_t> at;
    for (size_t i = 0; i < count; ++i) {
      const OrientationFrame& frame = FrameOf(layer_.nodes[i].frame);
      if (features[i].size() == 0) continue;
      at[frame.id] = nodes.size();
      nodes.push_back({{.features = &features[i], .frame = &frame}, MapOf(frame.sequence)});
    }
    ProgressReporter nobody;
    loops_ = FindLoops(nodes, options_.loops, options_.traversability, nobody);
    result_.loops = static_cast<int>(loops_.size());
    for (const OrientationEdge& loop : loops_) {
      const OrientedFeatures& a = nodes[at.at(loop.a)].features;
      const OrientedFeatures& b = nodes[at.at(loop.b)].features;
      const Traversal traversal = TestTraversability(a, b, options_.traversability);
      Vote(*a.frame, *b.frame, traversal.pose.b_from_a, traversal.matches);
    }
  }

  void VoteByPanoramas(const std::vector<Recognition>& recognitions,
                       const std::vector<size_t>& firsts) {
    for (const Recognition& recognition : recognitions) {
      for (const RecognisedNode& one : recognition.nodes) {
        if (!one.asking_from_best) continue;
        const auto& nodes = map_.appearance->nodes;
        const AppearanceNode& best = nodes[firsts[recognition.asked] + one.best];
        const AppearanceNode& asking = nodes[firsts[recognition.asking] + one.asking];
        const OrientationFrame* a = FindFrame(best.sequence, best.frame);
        const OrientationFrame* b = FindFrame(asking.sequence, asking.frame);
        if (a != nullptr && b != nullptr) Vote(*a, *b, *one.asking_from_best, one.inliers);
      }
    }
  }

  // Turns groups, starting from settled ones, in the order of the strongest clear evidence.
  void TurnGroups() {
    std::map<SequenceId, int> settled;  // quarter turns of each group
    for (const auto& [sequence, group] : group_of_) {
      if (settled.contains(group)) continue;
      settled[group] = 0;
      while (SettleNext(settled)) {
      }
    }
    for (const auto& [sequence, group] : group_of_) {
      const int turns = settled.at(group);
      if (turns == 0) continue;
      TurnSequence(sequence, turns, layer_);
      ++result_.sequences_turned;
    }
  }

  bool SettleNext(std::map<SequenceId, int>& settled) const {
    int64_t most = 0;
    std::pair<SequenceId, int> next;
    for (const auto& [pair, votes] : votes_) {
      const auto known = settled.find(pair.first);
      if (known == settled.end() || settled.contains(pair.second)) continue;
      const auto best = std::ranges::max_element(votes);
      int64_t all = 0;
      for (const int64_t one : votes) all += one;
      if (2 * *best <= all || *best <= most) continue;
      most = *best;
      next = {pair.second, (known->second + static_cast<int>(best - votes.begin())) % 4};
    }
    if (most == 0) return false;
    settled.insert(next);
    return true;
  }

  const std::vector<SequenceId>& maps_;
  const OrientationOptions& options_;
  MapData& map_;
  OrientationLayer& layer_;
  std::map<std::pair<SequenceId, int>, const OrientationFrame*> frames_;
  std::map<SequenceId, SequenceId> group_of_;  // the first sequence of its group
  Votes votes_;
  std::vector<OrientationEdge> loops_;
  OrientationJoin result_;
};

}  // namespace

void TurnSequence(SequenceId sequence, int turns, OrientationLayer& layer) {
  const Matrix3d turn = QuarterTurns(((turns % 4) + 4) % 4);
  const bool swaps = turns % 2 != 0;
  std::map<OrientationFrameId, bool> is_turned;
  for (OrientationFrame& frame : layer.frames) {
    if (frame.sequence != sequence) continue;
    is_turned[frame.id] = true;
    if (swaps) std::swap(frame.lines[0], frame.lines[1]);
    if (!frame.rotation) continue;
    Eigen::Quaterniond& rotation = frame.rotation->building_from_rig;
    rotation = (Eigen::Quaterniond(turn) * rotation).normalized();
    if (rotation.w() < 0) rotation.coeffs() = -rotation.coeffs();
    frame.rotation->covariance = turn * frame.rotation->covariance * turn.transpose();
  }
  if (!swaps) return;
  for (OrientationTurn& row : layer.turns) {
    if (is_turned.contains(row.frame)) row.axis_after = 1 - row.axis_after;
  }
  for (Corridor& row : layer.corridors) {
    if (is_turned.contains(row.first)) row.axis = 1 - row.axis;
  }
}

OrientationJoin JoinOrientation(const std::vector<Recognition>& recognitions,
                                const std::vector<size_t>& firsts,
                                const std::vector<SequenceId>& maps,
                                const OrientationOptions& options, MapData& map) {
  if (!map.orientation) return {};
  return OrientationJoiner(maps, options, map).Join(recognitions, firsts);
}

}  // namespace waystone
