// SPDX-License-Identifier: Apache-2.0
#include "core/homography/homography.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/check.h"
#include "core/geometry/linear_algebra.h"
#include "core/homography/transfer_jacobian.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Matrix9d = Eigen::Matrix<double, 9, 9>;
using Vector8d = Eigen::Matrix<double, 8, 1>;
using Matrix8d = Eigen::Matrix<double, 8, 8>;

// The similarity that moves points to mean 0 and mean distance sqrt(2) (Hartley's normalisation).
Matrix3d NormalisingTransform(const std::vector<Vector2d>& points) {
  Vector2d mean = Vector2d::Zero();
  for (const Vector2d& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  double distance = 0;
  for (const Vector2d& p : points) distance += (p - mean).norm();
  distance /= static_cast<double>(points.size());
  const double scale = distance > 0 ? std::sqrt(2.0) / distance : 1.0;
  Matrix3d t;
  t << scale, 0, -scale * mean.x(), 0, scale, -scale * mean.y(), 0, 0, 1;
  return t;
}

double TwiceArea(const Vector2d& p, const Vector2d& q, const Vector2d& r) {
  return (q.x() - p.x()) * (r.y() - p.y()) - (q.y() - p.y()) * (r.x() - p.x());
}

// The matrix that sends the standard projective frame to four points, or nothing when degenerate.
std::optional<Matrix3d> FrameOf(std::span<const Vector2d, 4> p) {
  Matrix3d basis;
  for (int i = 0; i < 3; ++i) basis.col(i) = p[i].homogeneous();
  const Vector3d weights = basis.inverse() * p[3].homogeneous();
  if (!weights.allFinite()) return std::nullopt;
  return basis * weights.asDiagonal();
}

// Whether any three of the four are nearly collinear or change orientation between the images.
bool Degenerate(std::span<const Vector2d, 4> a, std::span<const Vector2d, 4> b,
                double min_height_ratio) {
  static constexpr std::array<std::array<int, 3>, 4> kTriples{
      {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}}};
  for (const auto& [i, j, k] : kTriples) {
    const double area_a = TwiceArea(a[i], a[j], a[k]);
    const double area_b = TwiceArea(b[i], b[j], b[k]);
    if (area_a * area_b <= 0) return true;
    const double side2_a = std::max(
        {(a[i] - a[j]).squaredNorm(), (a[j] - a[k]).squaredNorm(), (a[k] - a[i]).squaredNorm()});
    const double side2_b = std::max(
        {(b[i] - b[j]).squaredNorm(), (b[j] - b[k]).squaredNorm(), (b[k] - b[i]).squaredNorm()});
    if (std::abs(area_a) < min_height_ratio * side2_a) return true;
    if (std::abs(area_b) < min_height_ratio * side2_b) return true;
  }
  return false;
}

Matrix3d FromVector(const Eigen::Matrix<double, 9, 1>& v) {
  Matrix3d h;
  h << v(0), v(1), v(2), v(3), v(4), v(5), v(6), v(7), v(8);
  return h;
}

struct NormalEquations {
  Matrix8d jtj = Matrix8d::Zero();
  Vector8d jtr = Vector8d::Zero();
  double cost = 0;
};

double Cost(const PointPairs& pairs, const Matrix3d& h) {
  const Matrix3d inverse = h.inverse();
  double cost = 0;
  for (int i = 0; i < pairs.size(); ++i) {
    cost += 2 * SymmetricTransferError2(h, inverse, pairs.a[i], pairs.b[i]);
  }
  return cost;
}

NormalEquations Linearise(const PointPairs& pairs, const Matrix3d& h) {
  const Matrix3d g = h.inverse();
  NormalEquations equations;
  for (int i = 0; i < pairs.size(); ++i) {
    const Vector3d a = pairs.a[i].homogeneous();
    const Vector3d b = pairs.b[i].homogeneous();
    const Vector3d mapped = h * a;
    Eigen::Matrix<double, 4, 8> jacobian;
    jacobian.topRows<2>() = ApplyJacobian(mapped, a).leftCols<8>();
    jacobian.bottomRows<2>() = InverseJacobian(g, b).leftCols<8>();
    Eigen::Vector4d residual;
    residual.head<2>() = mapped.hnormalized() - pairs.b[i];
    residual.tail<2>() = (g * b).hnormalized() - pairs.a[i];
    equations.jtj.noalias() += jacobian.transpose() * jacobian;
    equations.jtr.noalias() += jacobian.transpose() * residual;
    equations.cost += residual.squaredNorm();
  }
  return equations;
}

Matrix3d Stepped(const Matrix3d& h, const Vector8d& step) {
  Matrix3d next = h;
  for (int k = 0; k < 8; ++k) next(k / 3, k % 3) += step(k);
  return next;
}

// Levenberg-Marquardt over the eight free entries (h33 = 1) in normalised coordinates.
std::optional<Matrix3d> Minimise(const PointPairs& pairs, Matrix3d h) {
  constexpr int kMaxSteps = 15;
  constexpr double kConverged = 1e-9;  // relative decrease of the cost
  double damping = 1e-4;
  NormalEquations equations = Linearise(pairs, h);
  for (int step = 0; step < kMaxSteps; ++step) {
    Matrix8d damped = equations.jtj;
    damped.diagonal() *= 1 + damping;
    const Matrix3d next = Stepped(h, SolveSymmetric(damped, -equations.jtr));
    const double cost = Cost(pairs, next);
    if (!std::isfinite(cost) || cost >= equations.cost) {
      damping *= 10;
      if (damping > 1e6) break;
      continue;
    }
    const bool converged = equations.cost - cost <= kConverged * equations.cost;
    h = next;
    damping = std::max(damping / 10, 1e-12);
    if (converged) break;
    equations = Linearise(pairs, h);
  }
  if (!h.allFinite()) return std::nullopt;
  return h;
}

Eigen::Matrix<double, 9, 1> ToVector(const Matrix3d& h) {
  Eigen::Matrix<double, 9, 1> v;
  v << h(0, 0), h(0, 1), h(0, 2), h(1, 0), h(1, 1), h(1, 2), h(2, 0), h(2, 1), h(2, 2);
  return v;
}

// left * (h + dh) * right for every column dh of a spread, scaled to h33 = 1 to first order.
Eigen::Matrix<double, 9, 8> Transformed(const Matrix3d& left, const Matrix3d& h,
                                        const Eigen::Matrix<double, 9, 8>& spread,
                                        const Matrix3d& right) {
  const Matrix3d moved = left * h * right;
  const double scale = moved(2, 2);
  Eigen::Matrix<double, 9, 8> result;
  for (int k = 0; k < 8; ++k) {
    const Matrix3d d = left * FromVector(spread.col(k)) * right;
    result.col(k) = ToVector(d / scale - moved * (d(2, 2) / (scale * scale)));
  }
  return result;
}

}  // namespace

PointPairs PointPairs::Subset(std::span<const int> rows) const {
  PointPairs subset;
  subset.a.reserve(rows.size());
  subset.b.reserve(rows.size());
  for (int row : rows) subset.Add(a[row], b[row]);
  return subset;
}

Matrix3d Normalised(const Matrix3d& h) {
  const double scale = std::abs(h(2, 2)) > 1e-12 * h.norm() ? h(2, 2) : h.norm();
  return h / scale;
}

Vector2d Apply(const Matrix3d& b_from_a, const Vector2d& x_a) {
  return (b_from_a * x_a.homogeneous()).hnormalized();
}

// H = s (R + t n' / d) has a positive determinant where s does, and (H x)_3 is then a positive
// multiple of the depth.
bool IsInFront(const Matrix3d& b_from_a, const Vector2d& x_a) {
  return b_from_a.determinant() * b_from_a.row(2).dot(x_a.homogeneous()) > 0;
}

bool OnSameSide(const Matrix3d& b_from_a, const Vector2d& x_a, const Vector2d& inside) {
  return b_from_a.row(2).dot(x_a.homogeneous()) * b_from_a.row(2).dot(inside.homogeneous()) > 0;
}

double SymmetricTransferError2(const Matrix3d& b_from_a, const Matrix3d& a_from_b,
                               const Vector2d& x_a, const Vector2d& x_b) {
  return 0.5 *
         ((Apply(b_from_a, x_a) - x_b).squaredNorm() + (Apply(a_from_b, x_b) - x_a).squaredNorm());
}

std::optional<Matrix3d> HomographyFromFour(std::span<const Vector2d, 4> a,
                                           std::span<const Vector2d, 4> b,
                                           double min_height_ratio) {
  if (Degenerate(a, b, min_height_ratio)) return std::nullopt;
  const std::optional<Matrix3d> frame_a = FrameOf(a);
  const std::optional<Matrix3d> frame_b = FrameOf(b);
  if (!frame_a || !frame_b) return std::nullopt;
  const Matrix3d h = *frame_b * frame_a->inverse();
  if (!h.allFinite()) return std::nullopt;
  return Normalised(h);
}

std::optional<Matrix3d> HomographyByDlt(const PointPairs& pairs, std::span<const double> weights) {
  WS_CHECK(weights.empty() || weights.size() == pairs.a.size(), "as many weights as pairs");
  if (pairs.size() < 4) return std::nullopt;
  const Matrix3d ta = NormalisingTransform(pairs.a);
  const Matrix3d tb = NormalisingTransform(pairs.b);
  // Sums of x x^T, weighed by 1, y1, y2 and y1^2 + y2^2: the blocks of the normal equations.
  Matrix3d xx = Matrix3d::Zero();
  Matrix3d y1xx = Matrix3d::Zero();
  Matrix3d y2xx = Matrix3d::Zero();
  Matrix3d yyxx = Matrix3d::Zero();
  for (int i = 0; i < pairs.size(); ++i) {
    const Vector3d x = ta * pairs.a[i].homogeneous();
    const Vector2d y = (tb * pairs.b[i].homogeneous()).head<2>();
    const Matrix3d one = (weights.empty() ? 1.0 : weights[i]) * x * x.transpose();
    xx += one;
    y1xx += y.x() * one;
    y2xx += y.y() * one;
    yyxx += y.squaredNorm() * one;
  }
  Matrix9d ata;
  ata << xx, Matrix3d::Zero(), -y1xx, Matrix3d::Zero(), xx, -y2xx, -y1xx, -y2xx, yyxx;
  const SymmetricEigen eigen = DecomposeSymmetric(ata);
  if (!eigen.converged) return std::nullopt;
  // Both are judged in normalised coordinates: in pixels they would depend on the image's size.
  constexpr double kUndetermined = 1e-10;  // second smallest eigenvalue, as a share of the largest
  constexpr double kSingular = 1e-6;       // determinant at unit norm
  const Matrix3d normalised = FromVector(eigen.vectors.col(0));
  if (!(eigen.values(1) > kUndetermined * eigen.values(8)) ||
      !(std::abs(normalised.determinant()) > kSingular)) {
    return std::nullopt;
  }
  const Matrix3d h = tb.inverse() * normalised * ta;
  if (!h.allFinite()) return std::nullopt;
  return Normalised(h);
}

std::optional<HomographyEstimate> RefineHomography(const PointPairs& pairs,
                                                   const Matrix3d& initial) {
  constexpr int kMinPairs = 5;  // four determine it and leave nothing to estimate the noise from
  if (pairs.size() < kMinPairs) return std::nullopt;
  const Matrix3d ta = NormalisingTransform(pairs.a);
  const Matrix3d tb = NormalisingTransform(pairs.b);
  const Matrix3d tb_inverse = tb.inverse();
  PointPairs normalised;
  for (int i = 0; i < pairs.size(); ++i) {
    normalised.Add(Apply(ta, pairs.a[i]), Apply(tb, pairs.b[i]));
  }
  const std::optional<Matrix3d> h = Minimise(normalised, Normalised(tb * initial * ta.inverse()));
  if (!h) return std::nullopt;

  const NormalEquations equations = Linearise(normalised, *h);
  const SymmetricEigen eigen = DecomposeSymmetric(equations.jtj);
  if (!eigen.converged || eigen.values(0) <= 0) return std::nullopt;
  // The errors in the two images are the same noise seen twice, so the information is counted
  // twice: hence the factor 2.
  const double variance = equations.cost / (4.0 * pairs.size() - 16.0);
  const Matrix8d root =
      eigen.vectors * (2 * variance * eigen.values.cwiseInverse()).cwiseSqrt().asDiagonal();
  HomographyEstimate estimate;
  estimate.b_from_a = Normalised(tb_inverse * *h * ta);
  Eigen::Matrix<double, 9, 8> spread = Eigen::Matrix<double, 9, 8>::Zero();
  spread.topRows<8>() = root;  // h33 is fixed
  estimate.spread = Transformed(tb_inverse, *h, spread, ta);
  estimate.sigma_px = std::sqrt(Cost(pairs, estimate.b_from_a) / (4.0 * pairs.size()));
  estimate.pairs = pairs.size();
  if (!estimate.b_from_a.allFinite() || !estimate.spread.allFinite()) return std::nullopt;
  return estimate;
}

HomographyEstimate Composed(const Matrix3d& c_from_b, const HomographyEstimate& b_from_a) {
  HomographyEstimate composed = b_from_a;
  composed.b_from_a = Normalised(c_from_b * b_from_a.b_from_a);
  composed.spread = Transformed(c_from_b, b_from_a.b_from_a, b_from_a.spread, Matrix3d::Identity());
  return composed;
}

double TransferSigma(const HomographyEstimate& b_from_a, const Vector2d& x_a) {
  const Eigen::Vector3d x = x_a.homogeneous();
  const Eigen::Vector3d y = b_from_a.b_from_a * x;
  double variance = 0;  // the sum over the independent causes of noise, to first order
  for (int cause = 0; cause < b_from_a.spread.cols(); ++cause) {
    const Eigen::Vector3d dy = FromVector(b_from_a.spread.col(cause)) * x;
    variance += (dy.head<2>() - y.hnormalized() * dy.z()).squaredNorm() / (y.z() * y.z());
  }
  return std::sqrt(variance);
}

Matrix3d Perturbed(const HomographyEstimate& estimate, const Vector8d& z) {
  return estimate.b_from_a + FromVector(estimate.spread * z);
}

}  // namespace waystone
