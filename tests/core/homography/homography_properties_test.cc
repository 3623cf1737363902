// SPDX-License-Identifier: Apache-2.0
// The algebra of homographies, as properties over generated ones.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <Eigen/LU>
#include <cmath>

#include "core/homography/homography.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

double Between(double low, double high) {
  return low + (high - low) * *rc::gen::inRange(0, 1'000'001) / 1e6;
}

// A homography that keeps points within a unit of the origin well before its horizon.
Matrix3d AnyHomography() {
  Matrix3d h = Matrix3d::Identity();
  for (int k = 0; k < 8; ++k) h(k / 3, k % 3) += Between(-0.2, 0.2);
  return h;
}

Vector2d AnyPoint() { return {Between(-1, 1), Between(-1, 1)}; }

bool Near(const Vector2d& x, const Vector2d& y) { return (x - y).norm() < 1e-9; }

template <class Property>
void ExpectAlways(const std::string& what, const Property& property) {
  EXPECT_TRUE(rc::check(what, property));
}

TEST(HomographyAlgebra, CompositionAppliesOneAfterTheOther) {
  ExpectAlways("Apply(GH, x) = Apply(G, Apply(H, x))", [] {
    const Matrix3d b_from_a = AnyHomography();
    const Matrix3d c_from_b = AnyHomography();
    const Vector2d x = AnyPoint();
    RC_ASSERT(Near(Apply(c_from_b * b_from_a, x), Apply(c_from_b, Apply(b_from_a, x))));
    const HomographyEstimate composed = Composed(c_from_b, {.b_from_a = b_from_a});
    RC_ASSERT(Near(Apply(composed.b_from_a, x), Apply(c_from_b * b_from_a, x)));
  });
}

TEST(HomographyAlgebra, TheInverseLeadsBack) {
  ExpectAlways("Apply(H^-1, Apply(H, x)) = x", [] {
    const Matrix3d h = AnyHomography();
    const Vector2d x = AnyPoint();
    RC_ASSERT(Near(Apply(h.inverse(), Apply(h, x)), x));
    RC_ASSERT(SymmetricTransferError2(h, h.inverse(), x, Apply(h, x)) < 1e-18);
  });
}

TEST(HomographyAlgebra, ScaleDoesNotMatter) {
  ExpectAlways("s H is H", [] {
    const Matrix3d h = AnyHomography();
    const double scale = Between(0.01, 100) * (*rc::gen::arbitrary<bool>() ? 1 : -1);
    RC_ASSERT(Normalised(scale * h).isApprox(Normalised(h), 1e-12));
  });
}

TEST(HomographyAlgebra, FourPairsGiveItBack) {
  ExpectAlways("HomographyFromFour and HomographyByDlt of exact pairs", [] {
    const Matrix3d h = AnyHomography();
    std::array<Vector2d, 4> a;
    std::array<Vector2d, 4> b;
    PointPairs pairs;
    for (int i = 0; i < 4; ++i) {  // one in each corner: no three in a line
      a[i] = Vector2d(i % 2 == 0 ? -1 : 1, i < 2 ? -1 : 1) * Between(0.7, 1);
      b[i] = Apply(h, a[i]);
      pairs.Add(a[i], b[i]);
    }
    const auto from_four = HomographyFromFour(a, b, 0);
    const auto by_dlt = HomographyByDlt(pairs);
    RC_ASSERT(from_four.has_value() && by_dlt.has_value());
    RC_ASSERT(from_four->isApprox(Normalised(h), 1e-7));
    RC_ASSERT(by_dlt->isApprox(Normalised(h), 1e-7));
  });
}

// Points in few places, on lines, or all the same.
TEST(HomographyAlgebra, DegenerateInputNeverGivesNaN) {
  ExpectAlways("nothing, or all finite", [] {
    const int count = *rc::gen::inRange(0, 9);
    PointPairs pairs;
    std::vector<double> weights;
    for (int i = 0; i < count; ++i) {
      pairs.Add({*rc::gen::inRange(0, 3), *rc::gen::inRange(0, 3)},
                {*rc::gen::inRange(0, 3), *rc::gen::inRange(0, 3)});
      weights.push_back(*rc::gen::inRange(0, 2));
    }
    const auto by_dlt = HomographyByDlt(pairs);
    RC_ASSERT(!by_dlt || by_dlt->allFinite());
    const auto weighted = HomographyByDlt(pairs, weights);
    RC_ASSERT(!weighted || weighted->allFinite());
    const auto refined = RefineHomography(pairs, by_dlt.value_or(Matrix3d::Identity()));
    RC_ASSERT(!refined || (refined->b_from_a.allFinite() && refined->spread.allFinite() &&
                           std::isfinite(refined->sigma_px)));
    if (count < 4) return;
    const auto from_four =
        HomographyFromFour(std::span(pairs.a).first<4>(), std::span(pairs.b).first<4>(), 0);
    RC_ASSERT(!from_four || from_four->allFinite());
  });
}

}  // namespace
}  // namespace waystone
