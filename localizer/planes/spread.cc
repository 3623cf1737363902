// SPDX-License-Identifier: Apache-2.0
#include "localizer/planes/spread.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/check.h"

namespace waystone {
namespace {

using Eigen::Vector2d;

constexpr double kDisc = 1.0 / 40;  // of the image's area
constexpr int kSamples = 40;        // of the covered area, along each side of the image

// Of two features that are this far apart, in scale_px, neither says what the other does. SIFT:
// they see different parts of the image, 4 x 4 cells of 3 sigma each (Lowe 2004, as OpenCV has it;
// scale_px is 2 sigma). ORB and AKAZE: 15 % of what they see (a patch as large as scale_px, and a
// grid ten times as large), as rendered buildings suggest.
double IndependentApart(FeatureType type) {
  switch (type) {
    case FeatureType::kSift:
      return 6;
    case FeatureType::kOrb:
      return 0.15;
    case FeatureType::kAkaze:
      return 1.5;
  }
  WS_CHECK(false, "unknown feature type");
}

// Rows or columns of samples within `radius` of x, of an image whose side is `side` px long.
struct Samples {
  int first;
  int last;
};
Samples SamplesNear(double x, double radius, double side) {
  const double step = side / kSamples;  // the first is at half of it
  return {std::max(0, static_cast<int>(std::ceil((x - radius) / step - 0.5))),
          std::min(kSamples - 1, static_cast<int>(std::floor((x + radius) / step - 0.5)))};
}

}  // namespace

bool CanShow(const Features& image, const Vector2d& x) {
  constexpr double kMargin = 0.05;  // of the image
  const Vector2d size(image.width, image.height);
  const Vector2d margin = kMargin * size;
  return (x.array() >= margin.array()).all() &&  // not for NaN
         (x.array() < (size - margin).array()).all() && !IsClipped(image, x);
}

int CountApart(const std::vector<Vector2d>& points, double apart) {
  std::vector<Vector2d> counted;
  for (const Vector2d& x : points) {
    const bool near = std::any_of(counted.begin(), counted.end(), [&](const Vector2d& other) {
      return (other - x).squaredNorm() < apart * apart;
    });
    if (!near) counted.push_back(x);
  }
  return static_cast<int>(counted.size());
}

int CountIndependent(const Features& image, std::span<const int> keypoints) {
  std::vector<Keypoint> all;
  for (const int row : keypoints) all.push_back(image.keypoints[row]);
  std::ranges::stable_sort(all, {}, &Keypoint::scale_px);  // more small ones fit
  const double scales = IndependentApart(image.type);
  std::vector<Keypoint> counted;
  for (const Keypoint& one : all) {
    const bool overlaps = std::ranges::any_of(counted, [&](const Keypoint& other) {
      const double apart = scales * (one.scale_px + other.scale_px) / 2;
      return (PositionOf(one) - PositionOf(other)).squaredNorm() < apart * apart;
    });
    if (!overlaps) counted.push_back(one);
  }
  return static_cast<int>(counted.size());
}

double ComputeCoverage(const std::vector<Vector2d>& points, int width, int height) {
  const double radius = std::sqrt(kDisc * width * height / std::numbers::pi);
  const Vector2d step = Vector2d(width, height) / kSamples;
  std::vector<bool> covered(kSamples * kSamples, false);
  for (const Vector2d& x : points) {
    const Samples columns = SamplesNear(x.x(), radius, width);
    const Samples rows = SamplesNear(x.y(), radius, height);
    for (int row = rows.first; row <= rows.last; ++row) {
      for (int column = columns.first; column <= columns.last; ++column) {
        const Vector2d sample = step.cwiseProduct(Vector2d(column + 0.5, row + 0.5));
        if ((sample - x).squaredNorm() <= radius * radius) covered[row * kSamples + column] = true;
      }
    }
  }
  return static_cast<double>(std::ranges::count(covered, true)) / (kSamples * kSamples);
}

}  // namespace waystone
