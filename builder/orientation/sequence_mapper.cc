// SPDX-License-Identifier: Apache-2.0
#include "builder/orientation/sequence_mapper.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "builder/orientation/corridors.h"

namespace waystone {
namespace {

std::vector<HeadingSample> CameraHeadings(const std::vector<OrientationFrame>& frames) {
  std::vector<HeadingSample> headings;
  for (int i = 0; i < std::ssize(frames); ++i) {
    headings.push_back(
        {.frame = i, .heading_rad = frames[i].reliable ? HeadingOf(frames[i]) : std::nullopt});
  }
  return headings;
}

}  // namespace

SequenceMapper::SequenceMapper(SequenceId id, int64_t first_frame_id,
                               const OrientationOptions& options)
    : id_(id),
      next_id_(first_frame_id),
      options_(options),
      follower_(options.follow, options.traversability, options.manhattan),
      watch_(options.turns) {}

void SequenceMapper::Add(const OrientationViewPtr& view) {
  FollowedFrame followed = follower_.Follow(view);
  mapped_.frames.push_back({.id = {next_id_++},
                            .sequence = id_,
                            .frame = view->info.number,
                            .source = view->info.source,
                            .time_s = view->info.time_s,
                            .reliable = followed.reliable,
                            .rotation = followed.rotation,
                            .lines = followed.axes.lines});
  recent_.push_back({view, std::move(followed.axes), followed.anchored});
  MeasureMotion();
  WatchTurn();
  TestTurns(false);
  LookFromNode();
  const auto reach = static_cast<size_t>(
      std::max({2 * options_.turns.reach, options_.motion_frames, options_.step}) + 1);
  for (; recent_.size() > reach; ++first_recent_) recent_.pop_front();
}

OrientedFeatures SequenceMapper::Oriented(int frame, const OrientationView& view) const {
  return {.features = &view.features, .frame = &mapped_.frames[frame]};
}

Traversal SequenceMapper::Test(int from, const OrientationView& from_view, int to,
                               const OrientationView& to_view) {
  ++mapped_.tests;
  return TestTraversability(Oriented(from, from_view), Oriented(to, to_view),
                            options_.traversability);
}

// The motion of the last few frames belongs to the frame in their middle.
void SequenceMapper::MeasureMotion() {
  const int to = static_cast<int>(mapped_.frames.size()) - 1;
  const int from = to - options_.motion_frames;
  if (from < 0 || to % options_.motion_frames != 0) return;
  const Traversal traversal = Test(from, *At(from).view, to, *At(to).view);
  const auto heading = At(to).anchored ? traversal.motion_rad : std::nullopt;
  motion_samples_.push_back({.frame = (from + to) / 2, .heading_rad = heading});
}

void SequenceMapper::WatchTurn() {
  const int frame = static_cast<int>(mapped_.frames.size()) - 1;
  const std::optional<double> heading = HeadingOf(mapped_.frames[frame]);
  if (!heading || !At(frame).anchored) return;
  if (const auto jump = watch_.Next(frame, *heading)) untested_.push_back(*jump);
}

// Tests between the frames `reach` before and after a jump, or the nearest available ones.
void SequenceMapper::TestTurns(bool at_end) {
  const int last = static_cast<int>(mapped_.frames.size()) - 1;
  const int reach = options_.turns.reach;
  while (!untested_.empty() && (at_end || untested_.front().frame + reach <= last)) {
    const HeadingJump jump = untested_.front();
    untested_.pop_front();
    const int from = std::max(first_recent_, jump.frame - reach);
    const int to = std::min(last, jump.frame + reach);
    const Traversal traversal = Test(from, *At(from).view, to, *At(to).view);
    jumps_.push_back(
        {.jump = jump, .connected = traversal.connected, .flow_rad = traversal.flow_rad});
    jump_nodes_.push_back({.frame = jump.frame,
                           .kind = OrientationNodeKind::kTurn,
                           .view = At(jump.frame).view,
                           .axes = At(jump.frame).axes,
                           .step_matches = traversal.connected ? traversal.matches : 0});
  }
}

void SequenceMapper::AddNode(int frame, OrientationNodeKind kind, int step_matches) {
  mapped_.nodes.push_back({.frame = frame,
                           .kind = kind,
                           .view = At(frame).view,
                           .axes = At(frame).axes,
                           .step_matches = step_matches});
}

// From the last node on, every n frames: is the trajectory still traversable? Where it isn't, the
// frame becomes a node and the search starts anew from it. A frame that shows nothing is
// inconclusive: the next one is tested instead.
void SequenceMapper::LookFromNode() {
  const int frame = static_cast<int>(mapped_.frames.size()) - 1;
  if (At(frame).view->features.size() == 0) return;
  if (mapped_.nodes.empty()) {
    // The first frames may be needed to settle the axes, on which loops depend.
    constexpr int kStepsToWait = 3;
    if (!mapped_.frames[frame].reliable && frame < kStepsToWait * options_.step) return;
    AddNode(frame, OrientationNodeKind::kTraversable, 0);
    last_looked_ = frame;
    return;
  }
  if (frame - last_looked_ < options_.step) return;
  const int before = std::exchange(last_looked_, frame);
  const NodeInWork& node = mapped_.nodes.back();
  if (Test(node.frame, *node.view, frame, *At(frame).view).connected) return;
  int matches = 0;
  if (before > node.frame && before >= first_recent_) {
    const Traversal step = Test(before, *At(before).view, frame, *At(frame).view);
    matches = step.connected ? step.matches : 0;
  }
  AddNode(frame, OrientationNodeKind::kTraversable, matches);
}

// Turns are nodes of their own; a turn at the frame of a node replaces it.
void SequenceMapper::AddTurnNodes(std::vector<NodeInWork>& nodes) {
  for (size_t i = 0; i < mapped_.turns.size(); ++i) {
    if (!mapped_.turns[i].confirmed) continue;
    const auto at = std::ranges::lower_bound(nodes, jump_nodes_[i].frame, {}, &NodeInWork::frame);
    if (at != nodes.end() && at->frame == jump_nodes_[i].frame) {
      at->kind = OrientationNodeKind::kTurn;
    } else {
      nodes.insert(at, jump_nodes_[i]);
    }
  }
}

// The last of the recent frames that shows anything; -1 without one.
int SequenceMapper::LastSeen() const {
  int frame = static_cast<int>(mapped_.frames.size()) - 1;
  while (frame >= first_recent_ && At(frame).view->features.size() == 0) --frame;
  return frame >= first_recent_ ? frame : -1;
}

MappedSequence SequenceMapper::Finish() {
  const int last = static_cast<int>(mapped_.frames.size()) - 1;
  if (mapped_.nodes.empty()) {
    const int frame = LastSeen();
    if (frame < 0) return std::move(mapped_);
    AddNode(frame, OrientationNodeKind::kTraversable, 0);
  }
  TestTurns(true);
  const bool seen = At(last).view->features.size() > 0;
  if (seen && mapped_.nodes.back().frame != last)
    AddNode(last, OrientationNodeKind::kTraversable, 0);
  mapped_.motions = SettledMotions(motion_samples_, options_.turns);
  mapped_.turns =
      DecideTurns(jumps_, mapped_.motions, CameraHeadings(mapped_.frames), options_.turns);
  AddTurnNodes(mapped_.nodes);
  std::vector<int> confirmed;
  for (const DecidedTurn& turn : mapped_.turns) {
    if (turn.confirmed) confirmed.push_back(turn.jump.frame);
  }
  mapped_.corridors = FindCorridors(mapped_.frames, confirmed, mapped_.motions, options_.corridors);
  return std::move(mapped_);
}

}  // namespace waystone
