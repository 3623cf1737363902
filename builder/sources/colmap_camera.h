// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "core/camera/camera.h"

// COLMAP's cameras.txt and cameras.bin: internal to builder/sources. Thread-safe.
namespace waystone {

// Whether the file's name ends in .bin or its first line that isn't empty or a comment reads like
// "1 PINHOLE 640 480 ...".
// Throws MapError(kBadCamera) when the file can't be read.
bool LooksLikeColmap(const std::filesystem::path& path);

// The one camera of the file, with its principal point moved to our pixel convention. Throws
// MapError(kBadCamera) with the line, also for several cameras (with their count).
Camera ReadColmapCamera(const std::filesystem::path& path);

}  // namespace waystone
