// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "cli/files/image_poses.h"
#include "localizer/index/map_index.h"
#include "quality/pose_error.h"

// Images with the places where they were taken; docs/evaluation.md describes the files.
namespace waystone {

struct LabelledQuery {
  std::filesystem::path image;
  std::vector<PlaceId> truth;  // empty: not in the map
  std::optional<TruePose> pose;
};

// A CSV file of queries about a map. Throws MapError: kFileUnreadable for the file and for an image
// that isn't there; kNotFound for an image or frame that the map doesn't have; kBadRequest for
// anything else that makes no sense. Those about a line name it.
std::vector<LabelledQuery> ReadQuerySet(const std::filesystem::path& path, const MapIndex& index);

// The images of a folder, ordered by path, with their poses: by name where the poses have names,
// else by the only number in the image's name, which is a time stamp if it has a fraction, a frame
// number if the name has other characters, and may be either if it is the whole name. All places of
// the map within `near_m` metres are true. Throws MapError: kFileUnreadable; kBadSource for a
// folder without any; kNotFound for an image without a pose, or with none or several numbers.
std::vector<LabelledQuery> ReadPosedImages(const std::filesystem::path& folder,
                                           const ImagePoses& truth, const PlacePoses& places,
                                           double near_m);

// All images of a folder and its subfolders, ordered by path, as queries that aren't in the map.
// Throws MapError: kFileUnreadable; kBadSource for a folder without any.
std::vector<LabelledQuery> ReadNegatives(const std::filesystem::path& folder);

// Where the map's images were taken, as far as the poses say. Throws MapError(kNotFound) where no
// image of the map has a pose.
PlacePoses PosesOfPlaces(const ImagePoses& poses, const MapIndex& index);

}  // namespace waystone
