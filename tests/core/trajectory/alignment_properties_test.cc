// SPDX-License-Identifier: Apache-2.0
// Procrustes alignment, as properties over generated shapes.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/geometry/angle.h"
#include "core/trajectory/shape_difference.h"

namespace waystone {
namespace {

using Eigen::Vector2d;

double DrawCoordinate(double low, double high) {
  return low + (high - low) * *rc::gen::inRange(0, 1'000'001) / 1e6;
}

Points2 DrawShape() {
  Points2 shape{{0, 0}, {3, 0}, {0, 1}};  // never a point or a line
  const int count = *rc::gen::inRange(0, 12);
  for (int i = 0; i < count; ++i) {
    shape.emplace_back(DrawCoordinate(-5, 5), DrawCoordinate(-5, 5));
  }
  return shape;
}

Similarity2 DrawSimilarity() {
  Similarity2 similarity;
  similarity.scale = DrawCoordinate(0.05, 20);
  similarity.rotation = Eigen::Rotation2Dd(DrawCoordinate(-kPi, kPi)).toRotationMatrix();
  if (*rc::gen::arbitrary<bool>()) similarity.rotation.col(1) *= -1;
  similarity.translation = {DrawCoordinate(-50, 50), DrawCoordinate(-50, 50)};
  return similarity;
}

Points2 Moved(const Similarity2& similarity, const Points2& points) {
  Points2 moved;
  for (const Vector2d& x : points) moved.push_back(similarity * x);
  return moved;
}

template <class Property>
void ExpectForShapes(const std::string& what, const Property& property) {
  EXPECT_TRUE(rc::check(what, property));
}

TEST(AlignmentProperties, GivesTheSimilarityBack) {
  ExpectForShapes("Align(S x, x) = S", [] {
    const Points2 shape = DrawShape();
    const Similarity2 truth = DrawSimilarity();
    const Similarity2 found = Align(Moved(truth, shape), shape);
    RC_ASSERT(std::abs(found.scale - truth.scale) < 1e-9 * truth.scale);
    RC_ASSERT(found.rotation.isApprox(truth.rotation, 1e-9));
    RC_ASSERT((found.translation - truth.translation).norm() < 1e-7);
    RC_ASSERT(CompareShapes(Moved(truth, shape), shape).mu < 1e-12);
  });
}

TEST(AlignmentProperties, TheDifferenceDoesNotSeeSimilarities) {
  ExpectForShapes("mu(S a, T b) = mu(a, b), between 0 and 1", [] {
    const Points2 a = DrawShape();
    Points2 b;
    for (const Vector2d& x : a) {
      b.push_back(x + Vector2d(DrawCoordinate(-2, 2), DrawCoordinate(-2, 2)));
    }
    RC_PRE((b[0] - b[1]).norm() > 1e-3);
    const double mu = CompareShapes(a, b).mu;
    RC_ASSERT(mu >= 0 && mu <= 1);
    const double moved = CompareShapes(Moved(DrawSimilarity(), a), Moved(DrawSimilarity(), b)).mu;
    RC_ASSERT(std::abs(moved - mu) < 1e-7);
  });
}

TEST(AlignmentProperties, WithoutScaleAndReflectionItIsAMotion) {
  ExpectForShapes("a proper rotation, and no nudge of it fits better", [] {
    const Points2 a = DrawShape();
    const Points2 b = Moved(DrawSimilarity(), DrawShape());
    const size_t count = std::min(a.size(), b.size());
    const Points2 truth(a.begin(), a.begin() + static_cast<std::ptrdiff_t>(count));
    const Points2 estimate(b.begin(), b.begin() + static_cast<std::ptrdiff_t>(count));
    const Similarity2 best = Align(truth, estimate, {.scale = false, .reflect = false});
    RC_ASSERT(best.scale == 1);
    RC_ASSERT(std::abs(best.rotation.determinant() - 1) < 1e-9);
    const auto cost = [&](const Similarity2& s) {
      double sum = 0;
      for (size_t i = 0; i < count; ++i) sum += (truth[i] - s * estimate[i]).squaredNorm();
      return sum;
    };
    Similarity2 nudged = best;
    nudged.rotation = Eigen::Rotation2Dd(DrawCoordinate(-0.1, 0.1)) * best.rotation;
    nudged.translation += Vector2d(DrawCoordinate(-0.1, 0.1), DrawCoordinate(-0.1, 0.1));
    RC_ASSERT(cost(best) <= cost(nudged) * (1 + 1e-9));
  });
}

// In few places, on lines, far out, next to nothing, or not finite.
TEST(AlignmentProperties, DegenerateInputIsRefusedOrFinite) {
  ExpectForShapes("kBadSource, or all finite", [] {
    const int count = *rc::gen::inRange(0, 7);
    const double size = std::pow(10.0, *rc::gen::element(-320, -160, -20, 0, 90, 160, 307));
    const auto odd = [&] {
      const int kind = *rc::gen::inRange(0, 60);
      if (kind == 0) return std::numeric_limits<double>::quiet_NaN();
      if (kind == 1) return std::numeric_limits<double>::infinity();
      return size * (kind % 3);
    };
    Points2 a;
    Points2 b;
    for (int i = 0; i < count; ++i) {
      a.emplace_back(odd(), odd());
      b.emplace_back(odd(), *rc::gen::inRange(0, 2));
    }
    try {
      const ShapeDifference difference = CompareShapes(a, b);
      RC_ASSERT(difference.mu >= 0 && difference.mu <= 1);
      const Similarity2& s = difference.truth_from_estimate;
      RC_ASSERT(std::isfinite(s.scale) && s.translation.allFinite());
      RC_ASSERT((s.rotation * s.rotation.transpose()).isIdentity(1e-9));
    } catch (const MapError& error) {
      RC_ASSERT(error.code() == ErrorCode::kBadSource);
    }
  });
}

}  // namespace
}  // namespace waystone
