// SPDX-License-Identifier: Apache-2.0
#include "core/homography/homology.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/geometry/linear_algebra.h"

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

// By which factor noise that neighbours share exceeds that of independent matches.
double SharedNoise(const HomographyEstimate& estimate, const HomologyOptions& options) {
  return std::sqrt(std::max(1.0, static_cast<double>(estimate.pairs) / options.independent));
}

// Root mean square of what is measured under draws of both homographies' noise.
template <typename Measure>
double SpreadOverDraws(const HomologyOptions& options, const Measure& measure) {
  Random random(options.seed);
  double sum = 0;
  for (int draw = 0; draw < options.draws; ++draw) {
    const Vector8d of_m = DrawNormals(random);
    const Vector8d of_n = DrawNormals(random);
    sum += std::pow(measure(of_m, of_n), 2);
  }
  return std::sqrt(sum / options.draws);
}

// TestHomology without the third eigenvalue: kTwoPlanes also for one and the same plane.
Homology TestPair(const HomographyEstimate& m, const HomographyEstimate& n,
                  const HomologyOptions& options) {
  Homology result;
  const Matrix3d measured = m.b_from_a.inverse() * n.b_from_a;  // H^{mn} = (H^m)^-1 H^n
  const HomologyEigenvalues values = ComputeEigenvalues(measured);
  if (!std::isfinite(values.split) || std::abs(values.scale) < 1e-9) return result;
  result.matrix = measured / values.scale;
  result.third_eigenvalue = values.third;
  result.split = values.split;

  const Matrix3d unit = UnitScale(m);
  const Matrix3d ideal =
      unit.inverse() * NearestHomology(unit * result.matrix * unit.inverse()) * unit;
  const double shared_m = SharedNoise(m, options);
  const double shared_n = SharedNoise(n, options);
  result.split_sigma = SpreadOverDraws(options, [&](const Vector8d& of_m, const Vector8d& of_n) {
    const Matrix3d two = Perturbed(m, shared_m * of_m).inverse() *
                         WithNoiseOf(n, m.b_from_a * ideal, shared_n * of_n);
    return ComputeEigenvalues(two).split;
  });
  if (result.split <= options.max_sigmas * result.split_sigma) {
    result.kind = HomologyKind::kTwoPlanes;
  }
  return result;
}

}  // namespace

void HomologyOptions::Check() const { CheckFields("homology", *this); }

HomologyEigenvalues ComputeEigenvalues(const Matrix3d& homology) {
  const Eigen::Vector3cd values = ComputeEigenvalues3x3(homology);
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

bool HaveHomology(const HomographyEstimate& m, const HomographyEstimate& n,
                  const HomologyOptions& options) {
  options.Check();
  return TestPair(m, n, options).kind != HomologyKind::kInvalid;
}

Homology TestHomology(const HomographyEstimate& m, const HomographyEstimate& n,
                      const HomologyOptions& options) {
  options.Check();
  Homology result = TestPair(m, n, options);
  if (result.kind == HomologyKind::kInvalid) return result;
  result.third_sigma = SpreadOverDraws(options, [&](const Vector8d& of_m, const Vector8d& of_n) {
    const Matrix3d same = Perturbed(m, of_m).inverse() * WithNoiseOf(n, m.b_from_a, of_n);
    return ComputeEigenvalues(same).third - 1;
  });
  if (std::abs(result.third_eigenvalue - 1) <= options.max_sigmas * result.third_sigma) {
    result.kind = HomologyKind::kSamePlane;
  }
  return result;
}

}  // namespace waystone
