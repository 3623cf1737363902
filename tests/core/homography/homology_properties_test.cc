// SPDX-License-Identifier: Apache-2.0
// Homologies, I + v p^T with a double eigenvalue, as properties over generated ones.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "core/homography/homology.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

double DrawEntry(double low, double high) {
  return low + (high - low) * *rc::gen::inRange(0, 1'000'001) / 1e6;
}

Vector3d DrawEntries() { return {DrawEntry(-1, 1), DrawEntry(-1, 1), DrawEntry(-1, 1)}; }

// An invertible change of coordinates.
Matrix3d DrawBasis() {
  Matrix3d basis = Matrix3d::Identity();
  for (int k = 0; k < 9; ++k) basis(k / 3, k % 3) += DrawEntry(-0.25, 0.25);
  return basis;
}

struct DrawnHomology {
  Matrix3d matrix;
  double third;
};

// One whose third eigenvalue is neither near the double one nor near 0.
DrawnHomology DrawHomology() {
  const Vector3d v = DrawEntries();
  const Vector3d p = DrawEntries();
  const double third = 1 + v.dot(p);
  RC_PRE(std::abs(third - 1) > 0.1 && std::abs(third) > 0.1);
  return {Matrix3d::Identity() + v * p.transpose(), third};
}

template <class Property>
void ExpectForEach(const std::string& what, const Property& property) {
  EXPECT_TRUE(rc::check(what, property));
}

bool IsFiniteHomology(const Homology& homology) {
  return homology.matrix.allFinite() && std::isfinite(homology.third_eigenvalue) &&
         std::isfinite(homology.split);
}

TEST(HomologyProperties, TheEigenvaluesAreOneOneAndTheThird) {
  ExpectForEach("at any scale and in any coordinates", [] {
    const DrawnHomology drawn = DrawHomology();
    const Matrix3d basis = DrawBasis();
    const double scale = DrawEntry(0.1, 10) * (*rc::gen::arbitrary<bool>() ? 1 : -1);
    const HomologyEigenvalues values =
        ComputeEigenvalues(scale * basis * drawn.matrix * basis.inverse());
    RC_ASSERT(std::abs(values.scale - scale) < 1e-5 * std::abs(scale));
    RC_ASSERT(values.split < 1e-5);
    RC_ASSERT(std::abs(values.third - drawn.third) < 1e-4);
  });
}

// The homology of (n, m) is the inverse of that of (m, n).
TEST(HomologyProperties, TheInverseHasTheInverseThird) {
  ExpectForEach("third(G^-1) = 1 / third(G)", [] {
    const DrawnHomology drawn = DrawHomology();
    const HomologyEigenvalues inverse = ComputeEigenvalues(drawn.matrix.inverse());
    RC_ASSERT(inverse.split < 1e-5);
    RC_ASSERT(std::abs(inverse.third * drawn.third - 1) < 1e-4);
  });
}

TEST(HomologyProperties, TwoHomographiesGiveTheirHomology) {
  ExpectForEach("H^{mn} = (H^m)^-1 H^n, whatever the homographies' scales", [] {
    const DrawnHomology drawn = DrawHomology();
    HomographyEstimate m;
    HomographyEstimate n;
    m.b_from_a = DrawBasis();
    n.b_from_a = DrawEntry(0.5, 2) * m.b_from_a * drawn.matrix;
    const Homology homology = TestHomology(m, n, {});
    RC_ASSERT(homology.matrix.isApprox(drawn.matrix, 1e-4));
    RC_ASSERT(std::abs(homology.third_eigenvalue - drawn.third) < 1e-4);
  });
}

TEST(HomologyProperties, DegenerateInputIsInvalidAndNeverNaN) {
  const double kOdd[] = {0,
                         1,
                         -1,
                         1e300,
                         1e-300,
                         std::numeric_limits<double>::infinity(),
                         std::numeric_limits<double>::quiet_NaN()};
  ExpectForEach("whatever the entries are", [&] {
    HomographyEstimate m;
    HomographyEstimate n;
    for (Matrix3d* h : {&m.b_from_a, &n.b_from_a}) {
      for (int k = 0; k < 9; ++k) (*h)(k / 3, k % 3) = kOdd[*rc::gen::inRange(0, 7)];
    }
    const Homology homology = TestHomology(m, n, {});
    RC_ASSERT(IsFiniteHomology(homology));
    if (!m.b_from_a.allFinite() || !n.b_from_a.allFinite()) {
      RC_ASSERT(homology.kind == HomologyKind::kInvalid);
    }
  });
}

}  // namespace
}  // namespace waystone
