// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "builder/appearance/appearance_layer.h"
#include "builder/frames/frame_report.h"
#include "builder/planes/keyframe_sample.h"
#include "localizer/options.h"

// Whether a finished map finds the images that it was made of: the least that it has to do.
namespace waystone {

// Each sampled keyframe is asked for as a query image; found where the answer is localized at it or
// near it (KeyframesAreNear). Costs about 30 ms a sample.
OwnImages FindOwnKeyframes(const MapData& map, const std::vector<SampledKeyframe>& samples,
                           const LocalizeOptions& options);

// The same for sampled panoramas that are nodes; found where the answer is localized at the node
// itself. The map has an appearance layer (WS_CHECK).
OwnImages FindOwnPanoramas(const MapData& map, const std::vector<AppearanceSampleFrame>& samples,
                           const PanoramaQueryOptions& options);

}  // namespace waystone
