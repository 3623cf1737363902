// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "builder/frames/layer_builder.h"
#include "builder/orientation/options.h"
#include "builder/orientation/sequence_mapper.h"
#include "builder/orientation/source_rig.h"
#include "schema/layers/orientation/orientation_layer.h"

namespace waystone {

// What building the layer did. Skipped frames could not be read; the layer keeps them without a
// rotation. FrameReport::observe_s is lines and features, add_s axes, turns and nodes.
struct OrientationReport : FrameReport {
  int unreliable = 0;   // frames without reliable axes, of those that could be read
  int tests = 0;        // of traversability
  double finish_s = 0;  // edges and loops, wall clock
};

// The orientation layer of calibrated sequences (Puig et al. 2012): the rotation of every frame in
// the building, turns, the topological map, corridors, loop closures, and the directions in which
// one can go from each node. Frames that can't be read or show no lines are kept without a reliable
// rotation, and the rest is mapped all the same. Memory grows by half a megabyte per node for a
// six-camera rig. Deterministic on any number of threads.
class OrientationLayerBuilder : public LayerBuilder {
 public:
  // Throws MapError(kBadOptions).
  explicit OrientationLayerBuilder(const OrientationOptions& options);

  std::string stage() const override { return "directions"; }
  bool NeedsJoinedFrames() const override { return false; }
  // Throws MapError(kBadCamera) for a source without a calibration.
  void StartSequence(SequenceId id, const Source& source) override;
  std::unique_ptr<Observation> Observe(const Frame& frame) const override;
  void Add(std::unique_ptr<Observation> observation, ProgressReporter& progress) override;
  void FinishSequence(const FrameReport& sequence) override;
  // Throws MapError(kBadSource) when no frame could be read.
  void Finish(MapData& map, ProgressReporter& progress) override;

  const OrientationReport& report() const { return report_; }

 private:
  OrientationOptions options_;
  std::optional<SourceRig> rig_;
  std::unique_ptr<SequenceMapper> mapper_;
  std::vector<MappedSequence> mapped_;
  OrientationReport report_;
};

}  // namespace waystone
