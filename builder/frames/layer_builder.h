// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "builder/frames/frame_report.h"
#include "builder/frames/progress.h"
#include "builder/sources/source.h"
#include "core/base/ids.h"
#include "schema/map_data.h"

namespace waystone {

// What a layer takes from one frame. Each layer derives its own.
struct Observation {
  virtual ~Observation() = default;

  FrameInfo info;
  std::string error;  // why the layer can't use the frame; empty when it can
};

// One layer of a map under construction. The pipeline (frame_pipeline.h) calls, for each sequence,
// StartSequence, then Observe for the frames in parallel and Add for the observations in their
// order, then FinishSequence; Finish comes after the last sequence. Only Observe is called from
// several threads at a time, and of the others only Add may run meanwhile.
class LayerBuilder {
 public:
  virtual ~LayerBuilder() = default;

  // Name of the progress stage in which the layer's frames are read.
  virtual std::string stage() const = 0;
  // Whether the layer observes Frame::grey; images of a rig aren't joined where no layer does.
  virtual bool NeedsJoinedFrames() const { return true; }

  // Frames of `source` follow. Throws MapError for a source that the layer can't use.
  virtual void StartSequence(SequenceId id, const Source& source) = 0;
  // The part of the work that needs no other frame: a pure function of the frame and the source.
  // Never null; a frame that can't be used comes with its error.
  virtual std::unique_ptr<Observation> Observe(const Frame& frame) const = 0;
  // Takes the next observation, including those of frames that can't be used. May run while later
  // frames are observed, so it must not change what Observe reads.
  virtual void Add(std::unique_ptr<Observation> observation, ProgressReporter& progress) = 0;
  // No frame follows. Throws MapError(kBadSource) for a sequence that isn't good enough.
  virtual void FinishSequence(const FrameReport& sequence) = 0;
  // Puts the layer into the map. Runs on the threads of the calling task arena.
  virtual void Finish(MapData& map, ProgressReporter& progress) = 0;
};

}  // namespace waystone
