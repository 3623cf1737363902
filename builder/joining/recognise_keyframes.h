// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/features/features.h"
#include "localizer/verdict/answer.h"
#include "schema/map_data.h"

namespace waystone {

// A keyframe that shows a place of another map.
struct RecognisedKeyframe {
  size_t asking = 0;                   // index in the keyframes that were asked for
  size_t found = 0;                    // index in the other map's keyframes: the nearest one
  std::optional<QueryPose> pose = {};  // in the other map's frame, where it has poses
};

// Which keyframes of `other` show places of `map`: each is localized by its
// stored picture (FeaturesOfPicture). So that no single mistake ties two buildings together, an
// answer counts only where the keyframe before or after it in its sequence was localized near the
// same place (KeyframesAreNear). In the order of the keyframes; the same on any number of threads.
std::vector<RecognisedKeyframe> RecogniseKeyframes(const MapData& map, const MapData& other,
                                                   const FeatureOptions& options);

}  // namespace waystone
