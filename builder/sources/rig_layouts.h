// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "builder/sources/rig_source.h"

// How folders hold a rig's images: internal to builder/sources. Thread-safe.
namespace waystone {

struct NamedImage {
  std::string moment;  // what its moment is called: the folder's or the file's name
  std::filesystem::path path;
};

// Images by camera, as they lie in a folder.
struct CameraImages {
  std::string layout;
  std::vector<std::string> cameras;
  std::vector<std::vector<NamedImage>> images;  // of each camera, in natural order
};

// The rig of a folder: `rig_file` where it is given, else rig.yaml in or beside the folder; nothing
// where there is neither. Throws MapError(kBadCamera).
std::optional<Rig> RigOfFolder(const std::filesystem::path& folder,
                               const std::optional<std::filesystem::path>& rig_file);

// Looks for images of cameras with these names, in folders or files that are named after them.
// Nothing when there are none; missing cameras are left out.
std::optional<CameraImages> FindCameraImages(const std::filesystem::path& folder,
                                             const std::vector<std::string>& names);

// Each moment's image of every camera of the rig. Throws MapError(kBadSource) for a camera without
// images, a moment without an image of a camera, and folders of different lengths.
std::vector<RigMoment> GroupMoments(const CameraImages& found, const Rig& rig,
                                    const std::filesystem::path& folder, double max_time_gap_s);

// A folder's images, or those of images/ in it, one moment each.
std::vector<RigMoment> ListMoments(const std::filesystem::path& folder);

}  // namespace waystone
