// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/features/features.h"
#include "schema/map_data.h"

namespace waystone {

// The distance, in the kernel's unit, that is `share` (in [0, 1]) of the largest that descriptors
// of a type can have. Shares are of Euclidean or Hamming distances, not of their squares.
double DistanceAt(FeatureType type, double share);

// A keypoint as another image would see it: position, scale and angle by the homography's local
// affinity.
Keypoint Transferred(const Eigen::Matrix3d& b_from_a, const Keypoint& keypoint_a);

// Keeps the features `kept` (ascending) and their descriptors, drops the others.
void KeepFeatures(std::span<const int> kept, Plane& plane);

// Of a plane with more than `plenty` features, drops those with fewer than `min_votes` votes, those
// with fewest first, as long as more than `plenty` are left. The order stays.
void DropSparseFeatures(int plenty, int min_votes, Plane& plane);

// Whether a position in a reference image of width x height pixels is in it or at most
// `max_extrapolation` image sizes outside.
bool IsWithinReach(const Eigen::Vector2d& reference, int width, int height,
                   double max_extrapolation);

// Convex hull of the features, px in the reference image.
std::vector<Eigen::Vector2d> ComputeOutline(const std::vector<PlaneFeature>& features);

// Looks up an image's keypoints by position. Refers to the features; they must outlive it.
class KeypointGrid {
 public:
  KeypointGrid(const Features& features, double radius_px);

  // The keypoint within the radius of `position` whose descriptor is nearest to `descriptor` and
  // not farther than `max_distance` (in the kernel's unit); -1 when there is none.
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
