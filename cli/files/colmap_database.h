// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "builder/planes/keyframe_sample.h"
#include "builder/poses/keyframe_matches.h"
#include "schema/map_data.h"

namespace waystone {

// What `colmap mapper` needs to reconstruct the poses of a map's keyframes.
struct ColmapProject {
  const MapData* map = nullptr;
  std::vector<SampledKeyframe> features;  // of each keyframe, in their order
  std::vector<MatchedKeyframes> matches;
};

// The name of a keyframe's image, by which ReadGivenPoses finds it again: its source, after its
// sequence where there are several; ".jpg" is added to a video's.
std::string ColmapImageName(const MapData& map, const Keyframe& keyframe);

// Writes COLMAP's database (its tables as of COLMAP 3.8, which later versions read): a camera per
// sequence, an image per keyframe with its id, keypoints, SIFT descriptors, and the verified
// matches with their fundamental matrices. A camera that the map doesn't know starts from COLMAP's
// own guess, a focal length of 1.2 times the longer side. The file is written whole or not at all.
// Throws MapError: kFileExists without `overwrite`, kFileUnwritable.
void WriteColmapDatabase(const ColmapProject& project, const std::filesystem::path& path,
                         bool overwrite);

}  // namespace waystone
