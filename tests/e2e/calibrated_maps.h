// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <vector>

namespace waystone {

// A calibrated camera that moves sideways before the corner of a made room, and its map; made once.
struct CornerWalk {
  std::filesystem::path map;             // "walls.db"
  std::filesystem::path images;          // "0.jpg", ...
  std::filesystem::path camera;          // their calibration
  std::vector<Eigen::Isometry3d> poses;  // world from camera, m
  Eigen::Vector2d corner;                // where the walls x = ..., y = ... meet, m
};
const CornerWalk& TheCorner();

// The map of a rig that was pushed through a corridor and around a corner to the right, with an
// appearance and an orientation layer ("turns.db"); made once.
const std::filesystem::path& TheTurns();

// A walk of the demo and the map of every second of its images with the true poses, in metres; made
// once.
struct PosedHall {
  std::filesystem::path map;   // "hall.db"
  std::filesystem::path walk;  // what `waystone demo --write` put there
};
const PosedHall& ThePosedHall();

}  // namespace waystone
