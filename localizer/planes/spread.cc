// SPDX-License-Identifier: Apache-2.0
#include "localizer/planes/spread.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/check.h"

namespace waystone {
namespace {

using Eigen::Vector2d;

constexpr double kDiscShare = 1.0 / 40;  // of the image's area
constexpr int kSamplesPerSide = 40;      // of the image, at which it is covered or not

// Two features this far apart, in units of scale_px, are independent. SIFT: their regions hardly
// overlap, 4 x 4 cells of 3 sigma each (Lowe 2004, as in OpenCV; scale_px is 2 sigma). ORB and
// AKAZE: 15 % of their regions, a patch as large as scale_px, and a grid ten times as large
// (docs/benchmarks.md, What was tried).
double IndependenceDistance(FeatureType type) {
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

// How many are taken one after the other, skipping each that is near one already taken.
template <typename T>
int CountUnlessNear(const std::vector<T>& all, auto&& are_near) {
  std::vector<T> taken;
  for (const T& one : all) {
    const bool near =
        std::ranges::any_of(taken, [&](const T& other) { return are_near(one, other); });
    if (!near) taken.push_back(one);
  }
  return static_cast<int>(taken.size());
}

bool AreNearer(const Vector2d& a, const Vector2d& b, double apart) {
  return (a - b).squaredNorm() < apart * apart;
}

// Rows or columns of samples within `radius` of x, of an image whose side is `side` px long.
struct Samples {
  int first;
  int last;
};
Samples SamplesNear(double x, double radius, double side) {
  const double step = side / kSamplesPerSide;  // the first sample is at half of it
  const double first = std::ceil((x - radius) / step - 0.5);
  const double last = std::floor((x + radius) / step - 0.5);
  return {static_cast<int>(std::clamp<double>(first, 0, kSamplesPerSide)),
          static_cast<int>(std::clamp<double>(last, -1, kSamplesPerSide - 1))};
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
  return CountUnlessNear(
      points, [&](const Vector2d& a, const Vector2d& b) { return AreNearer(a, b, apart); });
}

int CountIndependent(std::vector<Keypoint> keypoints, FeatureType type) {
  std::ranges::stable_sort(keypoints, {}, &Keypoint::scale_px);  // more small ones fit
  const double scales = IndependenceDistance(type);
  return CountUnlessNear(keypoints, [&](const Keypoint& a, const Keypoint& b) {
    return AreNearer(PositionOf(a), PositionOf(b), scales * (a.scale_px + b.scale_px) / 2);
  });
}

double ComputeCoverage(const std::vector<Vector2d>& points, int width, int height) {
  const double radius = std::sqrt(kDiscShare * width * height / std::numbers::pi);
  const Vector2d step = Vector2d(width, height) / kSamplesPerSide;
  std::vector<bool> covered(kSamplesPerSide * kSamplesPerSide, false);
  for (const Vector2d& x : points) {
    const Samples columns = SamplesNear(x.x(), radius, width);
    const Samples rows = SamplesNear(x.y(), radius, height);
    for (int row = rows.first; row <= rows.last; ++row) {
      for (int column = columns.first; column <= columns.last; ++column) {
        const Vector2d sample = step.cwiseProduct(Vector2d(column + 0.5, row + 0.5));
        if (AreNearer(sample, x, radius)) covered[row * kSamplesPerSide + column] = true;
      }
    }
  }
  return static_cast<double>(std::ranges::count(covered, true)) /
         (kSamplesPerSide * kSamplesPerSide);
}

}  // namespace waystone
