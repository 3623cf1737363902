// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "core/base/options.h"
#include "world/room_scene.h"

// Synthetic flats with what makes homes hard for panoramic cameras: small rooms with white walls,
// furniture within reach, windows that blind the camera, mirrors, lamps that are on or off,
// doorways and a flight of stairs.
namespace waystone {

struct FlatOptions {
  uint64_t seed = 1;
  int columns = 3;
  int rows = 2;
  double min_side_m = 2.0;
  double max_side_m = 4.0;
  int furniture = 9;
  double wall_contrast = 0.02;

  static constexpr auto Fields(const auto& use) {
    using O = FlatOptions;
    return use(
        OptionField{"seed", &O::seed, AnyValue(), "",
                    "Random seed of rooms, furniture and appearance."},
        OptionField{"columns", &O::columns, Closed(1, 6), "rooms",
                    "Number of rooms from west to east. One room of the flat contains the stairs."},
        OptionField{"rows", &O::rows, Closed(1, 6), "rooms",
                    "Number of rooms from south to north."},
        OptionField{"min_side_m", &O::min_side_m, Closed(1.5, 10), "m", "Minimum side of a room."},
        OptionField{"max_side_m", &O::max_side_m, Closed(1.5, 10), "m",
                    "Maximum side of a room, at least min_side_m."},
        OptionField{
            "furniture", &O::furniture, Closed(0, 30), "",
            "Number of pieces of furniture that the generator tries to place in each room."},
        OptionField{"wall_contrast", &O::wall_contrast, Closed(0, 1), "",
                    "Contrast of the patterns on walls: plain paint has hardly any."});
  }
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

// Throws MapError(kBadOptions). Pure; thread-safe, as are the functions below.
Flat MakeFlat(const FlatOptions& options);

// `per_room` places in each room, at least `clearance_m` from what stands there; one in each
// doorway, and one on every other step. Cameras are `height_m` above what they stand on, give or
// take a few centimetres.
std::vector<FlatPlace> DrawFlatPlaces(const Flat& flat, int per_room, double height_m,
                                      double clearance_m, uint64_t seed);

// The lighting of a flat during a visit: the day outside is bright, dull or dark, and lamps are on
// or off.
SceneLighting DrawFlatLighting(const Flat& flat, uint64_t seed);

struct FlatCamera {
  int width_px = 512;
  double middle_grey = 110;
  double glare = 0.1;
  double noise_sigma = 3;
  uint64_t noise_seed = 0;

  static constexpr auto Fields(const auto& use) {
    using O = FlatCamera;
    return use(
        OptionField{"width_px", &O::width_px, Closed(32, 8192), "px",
                    "Width of the panorama, twice its height."},
        OptionField{"middle_grey", &O::middle_grey, Closed(20, 200), "grey levels",
                    "Grey level to which the median light of the image is exposed: light ten times "
                    "as bright (windows) is clipped."},
        OptionField{"glare", &O::glare, Closed(0, 1), "",
                    "Share of the light beyond white that spreads around its source."},
        OptionField{"noise_sigma", &O::noise_sigma, Closed(0, 100), "grey levels",
                    "Standard deviation of the noise per pixel."},
        OptionField{"noise_seed", &O::noise_seed, AnyValue(), "", "Random seed of that noise."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// An equirectangular panorama (CV_8UC1) as a camera with automatic exposure would take it. The pose
// is as for Renderer. The same on any thread.
cv::Mat RenderFlat(const Flat& flat, const SceneLighting& lighting,
                   const Eigen::Isometry3d& world_from_camera, const FlatCamera& camera);

// Two visits to a flat, each with its own lighting, with a hand-held camera.
struct FlatTourOptions {
  int per_room = 5;
  double height_m = 1.5;
  double clearance_m = 0.3;
  double tilt_rad = 0.03;
  double later_share = 0.35;
  FlatCamera camera;
  uint64_t seed = 1;

  static constexpr auto Fields(const auto& use) {
    using O = FlatTourOptions;
    return use(
        OptionField{"per_room", &O::per_room, Closed(1, 100), "", "Number of places in each room."},
        OptionField{"height_m", &O::height_m, Closed(0.2, 2), "m", "Height of the camera."},
        OptionField{"clearance_m", &O::clearance_m, Closed(0, 1), "m",
                    "Minimum distance of the camera from furniture and walls."},
        OptionField{"tilt_rad", &O::tilt_rad, Closed(0, 0.5), "rad",
                    "Standard deviation of pitch and roll."},
        OptionField{"later_share", &O::later_share, Closed(0, 1), "",
                    "Share of the places that the second visit sees."},
        OptionGroup{"camera", &O::camera},
        OptionField{"seed", &O::seed, AnyValue(), "",
                    "Random seed of places, headings, light and noise."});
  }
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
