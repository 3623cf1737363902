// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "builder/frames/progress.h"
#include "builder/planes/keyframe_sample.h"
#include "localizer/planes/plane_query_options.h"
#include "schema/map_data.h"

namespace waystone {

// Links keyframes of different visits to one place, which planes may not tie together: keyframes
// outside an image's own surroundings that its features vote for are verified, and the image's
// keyframe is linked with the best one and with those that look as well, where the keyframe's
// verdict is sure enough for an answer. So that no single mistake ties two places together, the
// image before or after it must have been found near the same place (KeyframesAreNear). A place
// that was passed just before or after (WereTakenInARow), where a stretch ended between the two,
// has to be more likely than not, and needs no other image. What is found again at two places that
// weren't passed one after the other, and of which none was found again near the other, looks like
// both: nothing near it is linked. `images` are of the map's keyframes, all or some, ordered by
// keyframe; those of keyframes that don't follow each other (FollowEachOther) confirm nothing.
// Returns how many keyframes got links; none in a map without landmarks. Reports the stage "links".
// Deterministic on any number of threads (it uses TBB's).
int LinkRevisits(const std::vector<SampledKeyframe>& images, const PlaneQueryOptions& options,
                 MapData& map, ProgressReporter& progress);

}  // namespace waystone
