// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "builder/planes/keyframe_sample.h"
#include "core/features/features.h"
#include "localizer/index/map_index.h"
#include "localizer/options.h"
#include "localizer/verdict/answer.h"
#include "schema/map_data.h"

namespace waystone {

// A keyframe that shows a place of another map.
struct RecognisedKeyframe {
  size_t asking = 0;                   // index in the keyframes that were queried
  size_t found = 0;                    // index in the other map's keyframes: the nearest one
  std::optional<QueryPose> pose = {};  // in the other map's frame, where it has poses
};

// A map and its answers to images of a walk, row by row, with poses where the map has some.
struct AskedMap {
  std::shared_ptr<const MapIndex> index;  // of the map's planes and landmarks
  LocalizeOptions options;                // of the queries
  std::vector<Answer> answers;
};

// Localizes images of `walk` in the map. The same on any number of threads.
AskedMap AskMap(const MapData& map, const MapData& walk, const std::vector<WalkImage>& images,
                const LocalizeOptions& options);

// Which keyframes of `other` show places of each of the maps: each is localized by its image, where
// that is among `images` (AskedMap has the answer), or by its stored picture (FeaturesOfPicture),
// which is described once for all maps. So that no single mistake connects two buildings, an answer
// counts only where the keyframe before or after it in its sequence was localized near the same
// place (KeyframesAreNear), or just before or after it (WereTakenInARow). One list per map, in the
// order of the keyframes; the same on any number of threads.
std::vector<std::vector<RecognisedKeyframe>> RecogniseKeyframes(
    const std::vector<const AskedMap*>& maps, const MapData& other,
    const std::vector<WalkImage>& images, const FeatureOptions& options);

}  // namespace waystone
