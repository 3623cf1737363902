// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "cli/files/pose_file.h"

namespace waystone {

// Reads the poses of COLMAP's images.bin (little-endian; camera_from_world there), and inverts
// them. Throws MapError: kFileUnreadable; kBadRequest for a file that is truncated or isn't one.
std::vector<FilePose> ReadColmapImages(const std::filesystem::path& path);

}  // namespace waystone
