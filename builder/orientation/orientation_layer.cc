// SPDX-License-Identifier: Apache-2.0
#include "builder/orientation/orientation_layer.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <utility>

#include "builder/orientation/loops.h"
#include "builder/orientation/sequence_mapper.h"
#include "builder/orientation/traversable_directions.h"
#include "core/base/angle.h"
#include "core/base/clock.h"
#include "core/base/error.h"

namespace waystone {
namespace {

using Progress = std::function<bool(const OrientationProgress&)>;

constexpr size_t kNamed = 20;  // unreadable frames that a report names

struct TimedView {
  TimedView(OrientationViewPtr looked, double seconds) : view(std::move(looked)), look_s(seconds) {}

  OrientationViewPtr view;
  double look_s;
};

void Count(const OrientationView& view, OrientationReport& report) {
  ++report.frames;
  if (view.error.empty()) return;
  ++report.unreadable;
  if (report.unreadable_names.size() < kNamed) {
    report.unreadable_names.push_back(view.info.source + ": " + view.error);
  }
}

void Report(const Progress& progress, const std::string& stage, int done) {
  if (progress && !progress({.stage = stage, .done = done})) {
    throw MapError(ErrorCode::kInterrupted,
                   "interrupted while building the orientation layer; nothing "
                   "was written");
  }
}

OrientedFeatures Oriented(const MappedSequence& mapped, const NodeInWork& node) {
  return {.features = &node.view->features, .frame = &mapped.frames[node.frame]};
}

// The way's axis at a node: that of the motion there, else the one nearest to the view ahead.
int TrajectoryAt(const MappedSequence& mapped, const NodeInWork& node) {
  for (const SettledMotion& motion : mapped.motions) {
    if (motion.last >= node.frame) return motion.quarter_turns;
  }
  if (!mapped.motions.empty()) return mapped.motions.back().quarter_turns;
  const double heading = HeadingOf(mapped.frames[node.frame]).value_or(0);
  return static_cast<int>(std::lround(heading / kQuarterTurn_rad) + 4) % 4;
}

OrientationNode NodeOf(const MappedSequence& mapped, const NodeInWork& work) {
  const OrientationFrame& frame = mapped.frames[work.frame];
  OrientationNode node{.frame = frame.id, .kind = work.kind, .directions = {}, .jpeg = {}};
  if (frame.reliable) {
    node.directions = TraversableDirections(work.view->lines, work.axes.axis_of_line,
                                            frame.rotation->building_from_rig.toRotationMatrix(),
                                            TrajectoryAt(mapped, work));
  }
  if (!work.view->thumbnail.empty()) cv::imencode(".jpg", work.view->thumbnail, node.jpeg);
  return node;
}

// Consecutive nodes are joined where the last step to the later one is traversable, or it is seen
// from the earlier one.
std::vector<OrientationEdge> TrajectoryEdges(const MappedSequence& mapped,
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

// A loop between nodes that the trajectory joins already is no news.
void AddLoops(const std::vector<MappedSequence>& sequences, const OrientationOptions& options,
              OrientationLayer& layer) {
  std::vector<LoopNode> nodes;
  for (const MappedSequence& mapped : sequences) {
    for (const NodeInWork& node : mapped.nodes) nodes.push_back({Oriented(mapped, node)});
  }
  const auto key = [](const OrientationEdge& edge) { return std::pair(edge.a, edge.b); };
  for (const OrientationEdge& loop : FindLoops(nodes, options.loops, options.traversability)) {
    if (std::ranges::find(layer.edges, key(loop), key) == layer.edges.end()) {
      layer.edges.push_back(loop);
    }
  }
  std::ranges::sort(layer.edges, {}, key);
}

void AddSequence(const MappedSequence& mapped, const OrientationOptions& options,
                 OrientationLayer& layer) {
  layer.frames.insert(layer.frames.end(), mapped.frames.begin(), mapped.frames.end());
  for (const DecidedTurn& turn : mapped.turns) {
    layer.turns.push_back({.frame = mapped.frames[turn.jump.frame].id,
                           .direction = turn.direction,
                           .angle_rad = turn.jump.angle_rad,
                           .confirmed = turn.confirmed,
                           .axis_after = turn.axis_after});
  }
  for (const NodeInWork& node : mapped.nodes) layer.nodes.push_back(NodeOf(mapped, node));
  const std::vector<OrientationEdge> edges = TrajectoryEdges(mapped, options);
  layer.edges.insert(layer.edges.end(), edges.begin(), edges.end());
  layer.corridors.insert(layer.corridors.end(), mapped.corridors.begin(), mapped.corridors.end());
}

}  // namespace

OrientationBuilder::OrientationBuilder(const OrientationOptions& options) : options_(options) {
  options.Check();
}

OrientationBuilder::~OrientationBuilder() = default;

void OrientationBuilder::StartSequence(SequenceId id) {
  FinishSequence();
  mapper_ = std::make_unique<SequenceMapper>(id, frames() + 1, options_);
}

void OrientationBuilder::Add(const OrientationViewPtr& view) {
  const Clock::time_point start = Clock::now();
  Count(*view, result_.report);
  mapper_->Add(view);
  result_.report.follow_s += SecondsSince(start);
}

void OrientationBuilder::FinishSequence() {
  if (!mapper_) return;
  mapped_.push_back(mapper_->Finish());
  result_.report.tests += mapped_.back().tests;
  mapper_.reset();
}

OrientationResult OrientationBuilder::Finish() {
  FinishSequence();
  OrientationReport& report = result_.report;
  if (report.frames == report.unreadable) {
    throw MapError(ErrorCode::kBadSource,
                   "none of " + std::to_string(report.frames) + " frames can be read" +
                       (report.frames > 0 ? ": " + report.unreadable_names[0] : ""));
  }
  const Clock::time_point start = Clock::now();
  OrientationLayer& layer = result_.layer;
  layer.step = options_.step;
  for (const MappedSequence& sequence : mapped_) AddSequence(sequence, options_, layer);
  AddLoops(mapped_, options_, layer);
  report.unreliable =
      static_cast<int>(std::ranges::count(layer.frames, false, &OrientationFrame::reliable)) -
      report.unreadable;
  report.finish_s = SecondsSince(start);
  return std::move(result_);
}

// Two frames a worker are in flight; the builder takes them in order.
double MapSequence(const OrientationSequence& sequence, const OrientationOptions& options,
                   const Progress& progress, OrientationBuilder& builder) {
  double look_s = 0;
  builder.StartSequence(sequence.id);
  const auto next = [&](tbb::flow_control& control) {
    auto moment = std::make_shared<std::optional<OrientationMoment>>(sequence.next());
    if (!*moment) control.stop();
    return moment;
  };
  const auto look = [&](const std::shared_ptr<std::optional<OrientationMoment>>& moment) {
    const Clock::time_point start = Clock::now();
    auto view = std::make_shared<OrientationView>(LookAt(sequence.rig, **moment, options));
    return std::make_shared<TimedView>(std::move(view), SecondsSince(start));
  };
  const auto take = [&](const std::shared_ptr<TimedView>& timed) {
    look_s += timed->look_s;
    builder.Add(timed->view);
    Report(progress, "frames", builder.frames());
  };
  const size_t in_flight = 2 * static_cast<size_t>(tbb::this_task_arena::max_concurrency()) + 1;
  using Moment = std::shared_ptr<std::optional<OrientationMoment>>;
  using View = std::shared_ptr<TimedView>;
  tbb::parallel_pipeline(in_flight,
                         tbb::make_filter<void, Moment>(tbb::filter_mode::serial_in_order, next) &
                             tbb::make_filter<Moment, View>(tbb::filter_mode::parallel, look) &
                             tbb::make_filter<View, void>(tbb::filter_mode::serial_in_order, take));
  return look_s;
}

OrientationResult BuildOrientationLayer(std::span<const OrientationSequence> sequences,
                                        const OrientationOptions& options,
                                        const Progress& progress) {
  const Clock::time_point start = Clock::now();
  OrientationBuilder builder(options);
  tbb::task_arena arena(options.threads > 0 ? options.threads : tbb::task_arena::automatic);
  return arena.execute([&] {
    double look_s = 0;
    for (const OrientationSequence& sequence : sequences) {
      look_s += MapSequence(sequence, options, progress, builder);
    }
    Report(progress, "loops", builder.frames());
    OrientationResult result = builder.Finish();
    result.report.look_s = look_s;
    result.report.total_s = SecondsSince(start);
    return result;
  });
}

}  // namespace waystone
