// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "builder/frames/progress.h"
#include "builder/planes/keyframe_sample.h"
#include "localizer/planes/plane_query_options.h"
#include "schema/map_data.h"

namespace waystone {

// Links keyframes of different visits to one place that planes may not connect. Among the earlier
// keyframes outside an image's own surroundings, those that its features vote for are verified, one
// per place. One after the other, keyframes are then linked with the best place and with its rivals
// (FindRivals), provided that the keyframe's verdict is sure enough for an answer and that by the
// links so far none of them is a rival any more. So that no single mistake connects two places, the
// image before or after it must have been found near the same place (KeyframesNear), or just before
// or after it. A place that was passed just before or after (WereTakenInARow), where a stretch
// ended between the two, has to be more likely than not, and needs no other image. `images` are of
// the map's keyframes, all or some, ordered by keyframe. The map has no links. Returns how many
// keyframes got links; none in a map without landmarks. Reports the stage "links". Deterministic on
// any number of threads (it uses TBB's).
int LinkRevisits(const std::vector<SampledKeyframe>& images, const PlaneQueryOptions& options,
                 MapData& map, ProgressReporter& progress);

}  // namespace waystone
