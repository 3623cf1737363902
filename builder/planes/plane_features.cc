// SPDX-License-Identifier: Apache-2.0
#include "builder/planes/plane_features.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "core/features/distance.h"
#include "core/homography/homography.h"

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

std::vector<Eigen::Vector2d> ComputeOutline(const std::vector<PlaneFeature>& features) {
  std::vector<cv::Point2f> points;
  points.reserve(features.size());
  for (const PlaneFeature& f : features) points.emplace_back(f.reference.x_px, f.reference.y_px);
  std::vector<cv::Point2f> hull;
  if (!points.empty()) cv::convexHull(points, hull);
  std::vector<Eigen::Vector2d> outline;
  for (const cv::Point2f& p : hull) outline.emplace_back(p.x, p.y);
  return outline;
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
  const DistanceKernel distance_to = FastestKernel(features_.type);
  const int centre = CellOf(position.x(), position.y());
  int best = -1;
  for (int row = centre / columns_ - 1; row <= centre / columns_ + 1; ++row) {
    for (int column = centre % columns_ - 1; column <= centre % columns_ + 1; ++column) {
      if (row < 0 || column < 0 || row >= rows_ || column >= columns_) continue;
      for (int i : cells_[static_cast<size_t>(row) * columns_ + column]) {
        const Keypoint& k = features_.keypoints[i];
        if (std::hypot(k.x_px - position.x(), k.y_px - position.y()) > radius_px_) continue;
        int32_t distance = 0;
        distance_to(descriptor, features_.descriptors.row(i), 1, features_.descriptors.bytes(),
                    &distance);
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
