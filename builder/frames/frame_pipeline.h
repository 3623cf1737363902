// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "builder/frames/layer_builder.h"

namespace waystone {

// Reads a source to its end: decodes each frame once, lets every layer observe it, both several
// frames at a time on the threads of the calling task arena, and adds the observations to each
// layer in the order of the frames. At most two frames per thread, and one more, are in memory.
// What the layers get doesn't depend on the number of threads. Returns the sequence, with the
// number of frames that the first layer skipped. `layers` has at least one. Throws what the layers
// throw, and MapError:
// kUnreadableFrames when a layer skipped more than `max_skipped_share` of the frames, kBadSource
// when it skipped all of them; kInterrupted.
Sequence ObserveSequence(Source& source, SequenceId id, std::span<LayerBuilder* const> layers,
                         ProgressReporter& progress, double max_skipped_share = 1);

// A map of these sources with only this layer. Turns OpenCV's own threads off for the whole
// process. Throws MapError(kBadSource) for no source, and what ObserveSequence and the layer throw.
MapData BuildLayer(const std::vector<Source*>& sources, LayerBuilder& layer,
                   const ProgressCallback& progress = {});

}  // namespace waystone
