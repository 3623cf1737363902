// SPDX-License-Identifier: Apache-2.0
#include "builder/orientation/orientation_layer.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <set>
#include <utility>

#include "builder/orientation/loops.h"
#include "builder/orientation/traversable_directions.h"
#include "core/base/clock.h"
#include "core/base/error.h"
#include "core/geometry/angle.h"
#include "core/image/encode.h"

namespace waystone {
namespace {

OrientedFeatures Oriented(const MappedSequence& mapped, const NodeInWork& node) {
  return {.features = &node.view->features, .frame = &mapped.frames[node.frame]};
}

// The trajectory's axis at a node: that of the motion there, else the one nearest to the view
// ahead.
int FindTrajectoryAxis(const MappedSequence& mapped, const NodeInWork& node) {
  for (const SettledMotion& motion : mapped.motions) {
    if (motion.last >= node.frame) return motion.quarter_turns;
  }
  if (!mapped.motions.empty()) return mapped.motions.back().quarter_turns;
  const double heading = HeadingOf(mapped.frames[node.frame]).value_or(0);
  return static_cast<int>(std::lround(heading / kQuarterTurn_rad) + 4) % 4;
}

OrientationNode MakeNode(const MappedSequence& mapped, const NodeInWork& work) {
  const OrientationFrame& frame = mapped.frames[work.frame];
  OrientationNode node{.frame = frame.id, .kind = work.kind, .directions = {}, .picture = {}};
  if (frame.reliable) {
    node.directions = TraversableDirections(work.view->lines, work.axes.axis_of_line,
                                            frame.rotation->building_from_rig.toRotationMatrix(),
                                            FindTrajectoryAxis(mapped, work));
  }
  // It is used to find lines and to match nodes when maps are joined, for which a JPEG keeps more
  // than a WebP.
  if (!work.view->thumbnail.empty()) node.picture = EncodeJpeg(work.view->thumbnail);
  return node;
}

// Consecutive nodes are joined where the last step to the later one is traversable, or it is seen
// from the earlier one.
std::vector<OrientationEdge> FindTrajectoryEdges(const MappedSequence& mapped,
                                                 const OrientationOptions& options) {
  if (mapped.nodes.empty()) return {};
  std::vector<int> matches(mapped.nodes.size() - 1);
  tbb::parallel_for(size_t{0}, matches.size(), [&](size_t i) {
    const NodeInWork& to = mapped.nodes[i + 1];
    matches[i] = to.step_matches;
    if (matches[i] > 0) return;
    const Traversal direct = TestTraversability(Oriented(mapped, mapped.nodes[i]),
                                                Oriented(mapped, to), options.traversability);
    if (direct.connected) matches[i] = direct.matches;
  });
  std::vector<OrientationEdge> edges;
  for (size_t i = 0; i < matches.size(); ++i) {
    if (matches[i] == 0) continue;
    edges.push_back({.a = mapped.frames[mapped.nodes[i].frame].id,
                     .b = mapped.frames[mapped.nodes[i + 1].frame].id,
                     .kind = OrientationEdgeKind::kTraversable,
                     .matches = matches[i]});
  }
  return edges;
}

// A loop between nodes that the trajectory already joins adds nothing.
void AddLoops(const std::vector<MappedSequence>& sequences, const OrientationOptions& options,
              ProgressReporter& progress, OrientationLayer& layer) {
  std::vector<LoopNode> nodes;
  for (const MappedSequence& mapped : sequences) {
    for (const NodeInWork& node : mapped.nodes) nodes.push_back({Oriented(mapped, node)});
  }
  const auto key = [](const OrientationEdge& edge) { return std::pair(edge.a, edge.b); };
  std::set<std::pair<OrientationFrameId, OrientationFrameId>> joined;
  for (const OrientationEdge& edge : layer.edges) joined.insert(key(edge));
  for (const OrientationEdge& loop :
       FindLoops(nodes, options.loops, options.traversability, progress)) {
    if (!joined.contains(key(loop))) layer.edges.push_back(loop);
  }
  std::ranges::sort(layer.edges, {}, key);
}

void AddSequence(const MappedSequence& mapped, const OrientationOptions& options,
                 OrientationLayer& layer) {
  layer.frames.insert(layer.frames.end(), mapped.frames.begin(), mapped.frames.end());
  for (const DecidedTurn& turn : mapped.turns) {
    layer.turns.push_back({.frame = mapped.frames[turn.jump.frame].id,
                           .direction = turn.direction,
                           .angle_rad = turn.angle_rad,
                           .confirmed = turn.confirmed,
                           .axis_after = turn.axis_after});
  }
  for (const NodeInWork& node : mapped.nodes) layer.nodes.push_back(MakeNode(mapped, node));
  const std::vector<OrientationEdge> edges = FindTrajectoryEdges(mapped, options);
  layer.edges.insert(layer.edges.end(), edges.begin(), edges.end());
  layer.corridors.insert(layer.corridors.end(), mapped.corridors.begin(), mapped.corridors.end());
}

}  // namespace

OrientationLayerBuilder::OrientationLayerBuilder(const OrientationOptions& options)
    : options_(options) {
  options.Check();
}

void OrientationLayerBuilder::StartSequence(SequenceId id, const Source& source) {
  rig_ = FindSourceRig(source);
  if (!rig_) {
    throw MapError(
        ErrorCode::kBadCamera,
        source.name() + " has no camera, which the orientation layer requires; use --camera");
  }
  mapper_ = std::make_unique<SequenceMapper>(id, report_.frames + 1, options_);
}

std::unique_ptr<Observation> OrientationLayerBuilder::Observe(const Frame& frame) const {
  std::string error = frame.error;
  if (!frame.images.empty()) {
    try {
      return ObserveOrientation(rig_->rig, frame.info, rig_->SplitIntoFaces(frame.images),
                                options_);
    } catch (const MapError& bad_image) {
      error = bad_image.what();
    }
  }
  auto unreadable = std::make_unique<OrientationView>();
  unreadable->info = frame.info;
  unreadable->error = error;
  return unreadable;
}

void OrientationLayerBuilder::Add(std::unique_ptr<Observation> observation, ProgressReporter&) {
  mapper_->Add(std::static_pointer_cast<const OrientationView>(
      std::shared_ptr<const Observation>(std::move(observation))));
}

void OrientationLayerBuilder::FinishSequence(const FrameReport& sequence) {
  report_.Append(sequence);
  mapped_.push_back(mapper_->Finish());
  // One camera can't distinguish corridors from rooms (SeesAllAround).
  if (rig_->rig.cameras.size() == 1) mapped_.back().corridors.clear();
  report_.tests += mapped_.back().tests;
  mapper_.reset();
}

void OrientationLayerBuilder::Finish(MapData& map, ProgressReporter& progress) {
  if (report_.frames == report_.skipped) {
    throw MapError(ErrorCode::kBadSource,
                   "none of " + std::to_string(report_.frames) + " frames can be read" +
                       (report_.frames > 0 ? ": " + report_.skipped_names[0] : ""));
  }
  const Clock::time_point start = Clock::now();
  OrientationLayer& layer = map.orientation.emplace();
  layer.step = options_.step;
  for (const MappedSequence& sequence : mapped_) AddSequence(sequence, options_, layer);
  AddLoops(mapped_, options_, progress, layer);
  report_.unreliable =
      static_cast<int>(std::ranges::count(layer.frames, false, &OrientationFrame::reliable)) -
      report_.skipped;
  report_.finish_s = SecondsSince(start);
}

}  // namespace waystone
