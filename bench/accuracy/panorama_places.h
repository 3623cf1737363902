// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "builder/sources/source.h"

namespace waystone::bench {

// A place with a panorama and its truth.
struct PanoramaPlace {
  std::string name;
  cv::Mat grey;                // CV_8UC1, equirectangular
  Eigen::Vector2d position_m;  // in the world, seen from above
  double yaw_rad = 0;          // of the front, counter-clockwise from the x axis
  std::vector<bool> hidden;    // by place: whether a wall is between; empty when not known
  // The same in full: metres, z up; the camera has x right, y down, z forward.
  Eigen::Isometry3d world_from_camera = Eigen::Isometry3d::Identity();
};

// poses.csv (id,x,y,z,qx,qy,qz,qw,...: rig to world, z up; rig z forward, y down) and
// panorama/ID.jpg of a folder. Throws MapError where they can't be read.
std::vector<PanoramaPlace> ReadPlaces(const std::filesystem::path& folder);

// `count` places in the demo building, at random in its rooms and with random headings and a tilt
// of a degree, each picture with its own noise and exposure.
std::vector<PanoramaPlace> RenderPlaces(int count, uint64_t seed);

// The places of a made flat (world/flat.h) on two visits under different lights; walls hide.
std::vector<PanoramaPlace> RenderFlatPlaces(uint64_t seed);

// The places in the order of a walk: from each to the nearest of those left.
std::vector<PanoramaPlace> InWalkOrder(std::vector<PanoramaPlace> places);

// Three quarters of the places for a map, and every fourth to query it with.
struct SplitPlaces {
  std::vector<PanoramaPlace> mapped;
  std::vector<PanoramaPlace> asked;
};
SplitPlaces Split(std::vector<PanoramaPlace> places);

// A sequence of the places from one to another, each numbered by its index in `places`, which must
// outlive it.
std::unique_ptr<Source> PanoramaSource(const std::vector<PanoramaPlace>& places, size_t first,
                                       size_t end, const std::string& name);

// Where the front of b points relative to that of a, and in which direction of a's frame b lies;
// counter-clockwise, radians.
double TrueHeading(const PanoramaPlace& a, const PanoramaPlace& b);
double TrueDirection(const PanoramaPlace& a, const PanoramaPlace& b);

}  // namespace waystone::bench
