// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "world/write_walk.h"

namespace waystone {

// Writes the pictures of a walk through the demo's building, with their truth, into `dir`, and
// plan.png, a drawing of the building of 540 x 500 px: the point (x, y) of the world, in metres, is
// at pixel (40 x, 500 - 40 y).
void WriteDemoWalk(const std::filesystem::path& dir, const WriteProgress& progress);

// Adds to a written walk photos from between its frames and photos of another building, with
// queries.csv, which says where they were taken. Throws MapError(kFileUnwritable).
void WriteDemoQueries(const std::filesystem::path& dir);

// Writes the panoramas of a setting (world/setting.h) with their truth, and odometry.csv, which
// holds what the robot's wheels would report, into `dir`. Throws MapError: kBadOptions for an
// unknown name, kFileExists, kFileUnwritable.
void WriteSetting(const std::string& name, const std::filesystem::path& dir,
                  const WriteProgress& progress);

// The demo's three photos.
struct DemoPhotos {
  std::filesystem::path right;      // of the same building, from between two of the walk's frames
  std::filesystem::path elsewhere;  // of another building
  std::filesystem::path broken;     // the first one, cut off
};

// Renders them into `dir`. Throws MapError(kFileUnwritable).
DemoPhotos WriteDemoPhotos(const std::filesystem::path& dir);

}  // namespace waystone
