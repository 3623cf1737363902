// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "builder/orientation/options.h"
#include "builder/orientation/sequence_mapper.h"
#include "builder/orientation/view.h"
#include "schema/layers/orientation/orientation_layer.h"

namespace waystone {

struct OrientationProgress {
  std::string stage;  // "frames", "loops"
  int done = 0;       // frames
};

struct OrientationReport {
  int frames = 0;
  int unreadable = 0;
  std::vector<std::string> unreadable_names;  // "017: cause", the first 20 of them
  int unreliable = 0;                         // of those that could be read
  int tests = 0;                              // of traversability
  double look_s = 0;                          // lines and features, summed over threads
  double follow_s = 0;                        // axes, turns, nodes: CPU of the part in order
  double finish_s = 0;                        // edges and loops, wall clock
  double total_s = 0;                         // wall clock
};

struct OrientationResult {
  OrientationLayer layer;
  OrientationReport report;
};

// Makes the layer from views that somebody else looks at, as BuildOrientationLayer does from
// sequences. Not thread-safe.
class OrientationBuilder {
 public:
  // Throws MapError(kBadOptions).
  explicit OrientationBuilder(const OrientationOptions& options);
  ~OrientationBuilder();

  // Views that follow are of this sequence; ids in ascending order.
  void StartSequence(SequenceId id);
  // The next view of the sequence, in order, also of a frame that could not be read.
  void Add(const OrientationViewPtr& view);
  int frames() const { return result_.report.frames; }
  // After the last view: edges, loops and the layer. Throws MapError(kBadSource) when no frame
  // could be read. Runs on the threads of the calling task arena.
  OrientationResult Finish();

 private:
  void FinishSequence();

  OrientationOptions options_;
  std::unique_ptr<SequenceMapper> mapper_;
  std::vector<MappedSequence> mapped_;
  OrientationResult result_;
};

// Reads a sequence into a builder: lines and features in parallel on the threads of the calling
// task arena, a bounded number of frames at a time. Returns the seconds that took, summed over
// threads.
double MapSequence(const OrientationSequence& sequence, const OrientationOptions& options,
                   const std::function<bool(const OrientationProgress&)>& progress,
                   OrientationBuilder& builder);

// The orientation layer of one or several calibrated sequences (Puig et al. 2012): the rotation of
// every frame in the building, turns, the topological map, corridors, loop closures, and the
// directions in which one can go from each node. Frames that can't be read or show no lines are
// kept without a reliable rotation, and the rest is mapped all the same. `progress` may be empty;
// when it returns false, the build stops with MapError(kInterrupted). Throws MapError(kBadSource)
// when no frame can be read, kBadOptions. Lines and features in parallel, a bounded number of
// frames at a time; memory grows by half a megabyte a node of a six-camera rig. Deterministic for
// any number of threads.
OrientationResult BuildOrientationLayer(
    std::span<const OrientationSequence> sequences, const OrientationOptions& options = {},
    const std::function<bool(const OrientationProgress&)>& progress = {});

}  // namespace waystone
