// SPDX-License-Identifier: Apache-2.0
#include "core/features/keypoint_grid.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/features/distance.h"

namespace waystone {
namespace {

constexpr double kMinCell_px = 8;

// RootSIFT descriptors have length 256 and no negative entries: they are orthogonal at most.
double LargestDistance(FeatureType type) {
  return type == FeatureType::kSift ? std::numbers::sqrt2 * 256 : 8.0 * DescriptorBytes(type);
}

}  // namespace

double DistanceAt(FeatureType type, double share) {
  const double distance = share * LargestDistance(type);
  return type == FeatureType::kSift ? distance * distance : distance;
}

KeypointGrid::KeypointGrid(const Features& features, double radius_px)
    : features_(features), radius_px_(radius_px) {
  const double cell = std::max(radius_px, kMinCell_px);
  columns_ = static_cast<int>(features.width / cell) + 1;
  rows_ = static_cast<int>(features.height / cell) + 1;
  cells_.resize(static_cast<size_t>(columns_) * rows_);
  for (int i = 0; i < features.size(); ++i) {
    const Keypoint& k = features.keypoints[i];
    cells_[CellOf(k.x_px, k.y_px)].push_back(i);
  }
}

int KeypointGrid::CellOf(double x, double y) const {
  const double cell = std::max(radius_px_, kMinCell_px);
  const int column = std::clamp(static_cast<int>(x / cell), 0, columns_ - 1);
  const int row = std::clamp(static_cast<int>(y / cell), 0, rows_ - 1);
  return row * columns_ + column;
}

int KeypointGrid::MostAlike(const Eigen::Vector2d& position, const uint8_t* descriptor,
                            double max_distance) const {
  const bool inside = position.x() >= 0 && position.y() >= 0 && position.x() < features_.width &&
                      position.y() < features_.height;
  if (!inside) return -1;
  const int centre = CellOf(position.x(), position.y());
  int best = -1;
  for (int row = centre / columns_ - 1; row <= centre / columns_ + 1; ++row) {
    for (int column = centre % columns_ - 1; column <= centre % columns_ + 1; ++column) {
      if (row < 0 || column < 0 || row >= rows_ || column >= columns_) continue;
      for (int i : cells_[static_cast<size_t>(row) * columns_ + column]) {
        const Keypoint& k = features_.keypoints[i];
        if (std::hypot(k.x_px - position.x(), k.y_px - position.y()) > radius_px_) continue;
        const int32_t distance =
            DescriptorDistance(features_.type, descriptor, features_.descriptors.row(i));
        if (distance <= max_distance) {
          max_distance = distance;
          best = i;
        }
      }
    }
  }
  return best;
}

}  // namespace waystone
