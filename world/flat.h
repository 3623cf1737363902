// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "world/room_scene.h"

// Made flats: what makes homes hard for cameras that see all around. Small rooms with white walls,
// furniture within reach, windows that blind the camera, mirrors, lamps that are on or off,
// doorways and a flight of stairs.
namespace waystone {

struct FlatOptions {
  // Rooms, furniture and looks all follow from it.
  uint64_t seed = 1;
  // Rooms from west to east and from south to north, 1 to 6. One of them holds the stairs.
  int columns = 3;
  int rows = 2;
  // A room's sides are between these, metres, 1.5 to 10.
  double min_side_m = 2.0;
  double max_side_m = 4.0;
  // Furniture that is tried for in each room, 0 to 30.
  int furniture = 9;
  // Contrast of the patterns on walls, 0 to 1: plain paint has hardly any.
  double wall_contrast = 0.02;

  void Check() const;  // throws MapError(kBadOptions)
};

enum class FlatPlaceKind : uint8_t { kRoom, kDoorway, kStairs };

// Where a camera may be.
struct FlatPlace {
  FlatPlaceKind kind = FlatPlaceKind::kRoom;
  Eigen::Vector3d at = Eigen::Vector3d::Zero();  // the camera's centre
};

struct FlatDoor {
  Eigen::Vector2d at = Eigen::Vector2d::Zero();  // the middle of the doorway
  int rooms[2] = {0, 0};
};

// A flat: everything about it is a function of the options.
struct Flat {
  RoomScene scene;
  std::vector<FlatDoor> doors;
  Eigen::Vector2d stairs_foot = Eigen::Vector2d::Zero();  // on the floor before the first step
  Eigen::Vector2d stairs_step = Eigen::Vector2d::Zero();  // from a step to the next, from above
  int steps = 0;
};

inline constexpr double kFlatStepRise_m = 0.18;

// Throws MapError(kBadOptions).
Flat MakeFlat(const FlatOptions& options);

// `per_room` places in each room, at least `clearance_m` from what stands there; one in each
// doorway, and one on every other step. Cameras are `height_m` above what they stand on, give or
// take a few centimetres.
std::vector<FlatPlace> DrawFlatPlaces(const Flat& flat, int per_room, double height_m,
                                      double clearance_m, uint64_t seed);

// How a visit finds a flat lit: the day outside is bright, dull or dark, and lamps are on or off.
SceneLighting DrawFlatLighting(const Flat& flat, uint64_t seed);

struct FlatCamera {
  int width_px = 512;  // of the panorama, twice its height
  // Grey level that half of the picture's light is exposed to, 20 to 200: what is ten times as
  // bright (windows) is cut off.
  double middle_grey = 110;
  // Share of the light beyond white that spreads around its source, 0 to 1.
  double glare = 0.1;
  double noise_sigma = 3;  // grey levels
  uint64_t noise_seed = 0;

  void Check() const;  // throws MapError(kBadOptions)
};

// An equirectangular panorama (CV_8UC1) as a camera with automatic exposure takes it. The pose is
// as Renderer's. The same on any thread.
cv::Mat RenderFlat(const Flat& flat, const SceneLighting& lighting,
                   const Eigen::Isometry3d& world_from_camera, const FlatCamera& camera);

// Two visits to a flat, each under a light of its own, with a camera that is held by hand.
struct FlatTourOptions {
  int per_room = 5;           // places in each room, 1 to 100
  double height_m = 1.5;      // of the camera
  double clearance_m = 0.3;   // from furniture and walls
  double tilt_rad = 0.03;     // sigma of pitch and roll
  double later_share = 0.35;  // of the places that the second visit sees, 0 to 1
  FlatCamera camera;
  uint64_t seed = 1;  // of places, headings, light and noise

  void Check() const;  // throws MapError(kBadOptions)
};

struct FlatPanorama {
  FlatPlace place;
  int visit = 0;
  Eigen::Isometry3d world_from_camera = Eigen::Isometry3d::Identity();
  cv::Mat grey;  // CV_8UC1, equirectangular
};

// Panoramas with random headings from DrawFlatPlaces; rendered on TBB's threads, the same on any
// number of them.
std::vector<FlatPanorama> PhotographFlat(const Flat& flat, const FlatTourOptions& options);

}  // namespace waystone
