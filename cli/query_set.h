// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <unordered_map>
#include <vector>

#include "core/base/ids.h"
#include "localizer/index/map_index.h"

// Images with the places where they were taken; docs/evaluation.md describes the files.
namespace waystone {

struct LabelledQuery {
  std::filesystem::path image;
  std::vector<KeyframeId> truth;  // empty: not in the map
  std::optional<Eigen::Vector3d> position_m;
};

// A CSV file of queries about a map. Throws MapError: kFileUnreadable for the file and for an image
// that isn't there; kNotFound for a keyframe or frame that the map doesn't have; kBadRequest for
// anything else that makes no sense. Those about a line name it.
std::vector<LabelledQuery> ReadQuerySet(const std::filesystem::path& path, const MapIndex& index);

// All images of a folder and the folders in it, ordered by path, as queries that aren't in the map.
// Throws MapError: kFileUnreadable; kBadSource for a folder without any.
std::vector<LabelledQuery> ReadNegatives(const std::filesystem::path& folder);

// Where keyframes were taken: of those of the map that the file names, by keyframe or frame. Throws
// like ReadQuerySet, but not for frames that are no keyframe.
using KeyframePositions = std::unordered_map<KeyframeId, Eigen::Vector3d>;
KeyframePositions ReadPositions(const std::filesystem::path& path, const MapIndex& index);

}  // namespace waystone
