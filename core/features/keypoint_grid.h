// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/features/features.h"

namespace waystone {

// The distance, in the unit of distance.h, that is `share` (in [0, 1]) of the largest possible one
// between descriptors of a type. Shares are of Euclidean or Hamming distances, not of their
// squares. Pure; thread-safe.
double DistanceAt(FeatureType type, double share);

// Looks up an image's keypoints by position. Refers to the features; they must outlive it.
// Immutable after construction: any number of threads may query it.
class KeypointGrid {
 public:
  KeypointGrid(const Features& features, double radius_px);

  // The keypoint within the radius of `position` whose descriptor is nearest to `descriptor` and
  // not farther than `max_distance` (in the unit of distance.h); -1 when there is none.
  int MostAlike(const Eigen::Vector2d& position, const uint8_t* descriptor,
                double max_distance) const;

 private:
  int CellOf(double x, double y) const;

  const Features& features_;
  double radius_px_;
  int columns_;
  int rows_;
  std::vector<std::vector<int>> cells_;
};

}  // namespace waystone
