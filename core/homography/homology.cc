// SPDX-License-Identifier: Apache-2.0
#include "core/homography/homology.h"

#include <Eigen/Dense>
#include <cmath>
#include <complex>

#include "core/base/error.h"
#include "core/base/linear_algebra.h"
#include "core/base/random.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Vector8d = Eigen::Matrix<double, 8, 1>;

Vector8d DrawNormals(Random& random) {
  Vector8d z;
  for (int k = 0; k < 8; ++k) z(k) = random.Normal();
  return z;
}

// The true homology that is nearest to a measured one: I + v p^T, the rank-one part of H - I.
Matrix3d NearestHomology(const Matrix3d& matrix) {
  const Eigen::JacobiSVD<Matrix3d> svd(matrix - Matrix3d::Identity(),
                                       Eigen::ComputeFullU | Eigen::ComputeFullV);
  return Matrix3d::Identity() +
         svd.singularValues()(0) * svd.matrixU().col(0) * svd.matrixV().col(0).transpose();
}

// The similarity that brings the plane's pixels to about unit size. Eigenvalues don't change under
// it, but sums of squares of matrix entries only mean something after it.
Matrix3d UnitScale(const HomographyEstimate& m) {
  const double pixels = std::max(1.0, std::hypot(m.b_from_a(0, 2), m.b_from_a(1, 2)));
  const double scale = 1.0 / std::max(pixels, 500.0);
  return Eigen::Vector3d(scale, scale, 1).asDiagonal();
}

// n's noise on another homography.
Matrix3d WithNoiseOf(const HomographyEstimate& n, const Matrix3d& b_from_a, const Vector8d& z) {
  return Normalised(b_from_a) + (Perturbed(n, z) - n.b_from_a);
}

}  // namespace

void HomologyOptions::Check() const {
  if (!(max_sigmas > 0) || draws < 10) {
    throw MapError(ErrorCode::kBadOptions,
                   "homology: max_deviations must be positive and draws at "
                   "least 10; use the defaults");
  }
}

HomologyEigenvalues EigenvaluesOf(const Matrix3d& homology) {
  const Eigen::Vector3cd values = EigenvaluesOf3x3(homology);
  int odd = 0;  // the one that is not in the closest pair
  double closest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const double distance = std::abs(values((i + 1) % 3) - values((i + 2) % 3));
    if (distance < closest) {
      closest = distance;
      odd = i;
    }
  }
  const std::complex<double> mean = 0.5 * (values((odd + 1) % 3) + values((odd + 2) % 3));
  HomologyEigenvalues result;
  result.scale = mean.real();
  result.split = closest / std::abs(mean);
  result.third = values(odd).real() / mean.real();
  return result;
}

Homology TestHomology(const HomographyEstimate& m, const HomographyEstimate& n,
                      const HomologyOptions& options) {
  options.Check();
  Homology result;
  const Matrix3d measured = m.b_from_a.inverse() * n.b_from_a;  // H^{mn} = (H^m)^-1 H^n
  const HomologyEigenvalues values = EigenvaluesOf(measured);
  if (!std::isfinite(values.split) || std::abs(values.scale) < 1e-9) return result;
  result.matrix = measured / values.scale;
  result.third_eigenvalue = values.third;
  result.split = values.split;

  const Matrix3d unit = UnitScale(m);
  const Matrix3d ideal =
      unit.inverse() * NearestHomology(unit * result.matrix * unit.inverse()) * unit;
  Random random(options.seed);
  double split2 = 0;
  double third2 = 0;
  for (int draw = 0; draw < options.draws; ++draw) {
    const Matrix3d m_inverse = Perturbed(m, DrawNormals(random)).inverse();
    const Vector8d z = DrawNormals(random);
    const auto two = EigenvaluesOf(m_inverse * WithNoiseOf(n, m.b_from_a * ideal, z));
    const auto same = EigenvaluesOf(m_inverse * WithNoiseOf(n, m.b_from_a, z));
    split2 += two.split * two.split;
    third2 += (same.third - 1) * (same.third - 1);
  }
  result.split_sigma = std::sqrt(split2 / options.draws);
  result.third_sigma = std::sqrt(third2 / options.draws);

  const bool pair_near_one = result.split <= options.max_sigmas * result.split_sigma;
  const bool third_near_one =
      std::abs(result.third_eigenvalue - 1) <= options.max_sigmas * result.third_sigma;
  if (!pair_near_one) {
    result.kind = HomologyKind::kInvalid;
  } else {
    result.kind = third_near_one ? HomologyKind::kSamePlane : HomologyKind::kTwoPlanes;
  }
  return result;
}

}  // namespace waystone
