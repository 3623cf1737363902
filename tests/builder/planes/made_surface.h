// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/base/random.h"
#include "schema/map_data.h"

namespace waystone {

// A flat thing with features, in a frame of its own (px of some picture of it).
struct Surface {
  std::vector<Eigen::Vector2d> points;
  std::vector<std::vector<uint8_t>> descriptors;

  // `count` features between two corners.
  void Add(int count, const Eigen::Vector2d& low, const Eigen::Vector2d& high, Random& random);
  void Add(const Surface& other);
};

// Features all over an image of 640x480.
Surface RandomSurface(Random& random, int count = 100);

// What a reference image of 640x480 shows of a surface, with noise; `h` takes the surface's points
// to the image's. Seen from the keyframe and the next one.
Plane PlaneOf(int64_t id, int64_t keyframe, const Surface& surface, const Eigen::Matrix3d& h,
              Random& random);

// Moves the corners of the image by up to 20 px.
Eigen::Matrix3d MildHomography(Random& random);

// Of 640x480, with the ids 1 to `count`.
std::vector<Keyframe> Keyframes(int count);

}  // namespace waystone
