// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <vector>

#include "builder/orientation/follow.h"
#include "builder/orientation/traversability.h"
#include "builder/orientation/turns.h"
#include "builder/orientation/view.h"
#include "schema/layers/orientation/orientation_layer.h"

namespace waystone {

// A node while the layer is being made.
struct NodeInWork {
  int frame = 0;  // index in the sequence
  OrientationNodeKind kind = OrientationNodeKind::kTraversable;
  OrientationViewPtr view;
  ManhattanFrame axes;  // of the view, numbered as the building's
  // Matches of the last step towards it; 0 where the view broke in that step too.
  int step_matches = 0;
};

// One sequence's part of the layer, before loops.
struct MappedSequence {
  std::vector<OrientationFrame> frames;
  std::vector<DecidedTurn> turns;
  std::vector<SettledMotion> motions;
  std::vector<Corridor> corridors;
  std::vector<NodeInWork> nodes;  // by frame
  int tests = 0;                  // of traversability
};

// Takes the views of one sequence in order and makes its topological map (sec. II-B): follows the
// axes, watches for turns, and looks from each node as far as the trajectory is traversable. Keeps
// only the views of the last few frames, of nodes and of jumps. Not thread-safe.
class SequenceMapper {
 public:
  SequenceMapper(SequenceId id, int64_t first_frame_id, const OrientationOptions& options);

  void Add(const OrientationViewPtr& view);
  // After the last view.
  MappedSequence Finish();

 private:
  struct Recent {
    OrientationViewPtr view;
    ManhattanFrame axes;
    bool anchored = false;  // its rotation is the building's
  };
  const Recent& At(int frame) const { return recent_[frame - first_recent_]; }
  int LastSeen() const;
  OrientedFeatures Oriented(int frame, const OrientationView& view) const;
  Traversal Test(int from, const OrientationView& from_view, int to,
                 const OrientationView& to_view);
  void MeasureMotion();
  void WatchTurn();
  void TestTurns(bool at_end);
  void LookFromNode();
  void AddNode(int frame, OrientationNodeKind kind, int step_matches);
  void AddTurnNodes(std::vector<NodeInWork>& nodes);

  SequenceId id_;
  int64_t next_id_;
  const OrientationOptions& options_;
  AxesFollower follower_;
  JumpWatch watch_;
  MappedSequence mapped_;
  std::deque<Recent> recent_;
  int last_looked_ = 0;   // last frame that was tested against the last node, or that node's frame
  int first_recent_ = 0;  // frame of recent_.front()
  std::vector<HeadingSample> motion_samples_;
  std::deque<HeadingJump> untested_;
  std::vector<TestedJump> jumps_;
  std::vector<NodeInWork> jump_nodes_;  // beside jumps_: nodes, should they be turns
};

}  // namespace waystone
