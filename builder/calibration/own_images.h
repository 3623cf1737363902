// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "builder/appearance/appearance_layer.h"
#include "builder/frames/frame_report.h"
#include "builder/planes/keyframe_sample.h"
#include "localizer/options.h"

// Whether a finished map recognises the images from which it was made: the least that it has to do.
// Both run on TBB's threads; deterministic, thread-safe.
namespace waystone {

// Queries the map with each sampled keyframe; it is found where the answer is localized at it or
// near it (KeyframesAreNear). Takes about 30 ms per sample.
OwnImages FindOwnKeyframes(const MapData& map, const std::vector<SampledKeyframe>& samples,
                           const LocalizeOptions& options);

// The same for sampled panoramas that are nodes; found where the answer is localized at the node
// itself or at one with an equal signature (in maps of several sessions). The map has an appearance
// layer (WS_CHECK).
OwnImages FindOwnPanoramas(const MapData& map, const std::vector<AppearanceSampleFrame>& samples,
                           const PanoramaQueryOptions& options);

}  // namespace waystone
