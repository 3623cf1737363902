// SPDX-License-Identifier: Apache-2.0
#include "builder/planes/plane_features.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/homography/homography.h"

namespace waystone {

Keypoint Transferred(const Eigen::Matrix3d& b_from_a, const Keypoint& keypoint_a) {
  const Eigen::Vector2d centre_a(keypoint_a.x_px, keypoint_a.y_px);
  const double radius = 0.5 * std::max(keypoint_a.scale_px, 1.0f);
  const Eigen::Vector2d along(std::cos(keypoint_a.angle_rad), std::sin(keypoint_a.angle_rad));
  const Eigen::Vector2d across(-along.y(), along.x());
  const Eigen::Vector2d centre = Apply(b_from_a, centre_a);
  const Eigen::Vector2d u = Apply(b_from_a, centre_a + radius * along) - centre;
  const Eigen::Vector2d v = Apply(b_from_a, centre_a + radius * across) - centre;
  const double area = std::abs(u.x() * v.y() - u.y() * v.x());
  double angle = std::atan2(u.y(), u.x());
  if (angle < 0) angle += 2 * std::numbers::pi;
  return {static_cast<float>(centre.x()), static_cast<float>(centre.y()),
          static_cast<float>(2 * std::sqrt(area)), static_cast<float>(angle)};
}

void KeepFeatures(std::span<const int> kept, Plane& plane) {
  std::vector<PlaneFeature> features;
  Descriptors descriptors(plane.descriptors.bytes());
  features.reserve(kept.size());
  descriptors.Reserve(static_cast<int>(kept.size()));
  for (int f : kept) {
    features.push_back(plane.features[f]);
    descriptors.Append(plane.descriptors.row(f));
  }
  plane.features = std::move(features);
  plane.descriptors = std::move(descriptors);
}

void DropSparseFeatures(int plenty, int min_votes, Plane& plane) {
  std::vector<int> kept(plane.features.size());
  std::iota(kept.begin(), kept.end(), 0);
  const auto votes = [&](int f) { return plane.features[f].votes; };
  std::stable_sort(kept.begin(), kept.end(), [&](int a, int b) { return votes(a) > votes(b); });
  while (std::ssize(kept) > plenty && votes(kept.back()) < min_votes) kept.pop_back();
  std::sort(kept.begin(), kept.end());
  KeepFeatures(kept, plane);
}

bool IsWithinReach(const Eigen::Vector2d& reference, int width, int height,
                   double max_extrapolation) {
  const double reach_x = max_extrapolation * width;
  const double reach_y = max_extrapolation * height;
  return reference.x() > -reach_x && reference.x() < width + reach_x && reference.y() > -reach_y &&
         reference.y() < height + reach_y;
}

std::vector<Eigen::Vector2d> PositionsOf(const Plane& plane) {
  std::vector<Eigen::Vector2d> positions;
  for (const PlaneFeature& feature : plane.features) {
    positions.push_back(PositionOf(feature.reference));
  }
  return positions;
}

}  // namespace waystone
