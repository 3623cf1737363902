// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

namespace waystone {

// Corresponding points of two images, row by row: a[i] and b[i], in pixels. All functions here are
// pure; thread-safe.
struct PointPairs {
  std::vector<Eigen::Vector2d> a;
  std::vector<Eigen::Vector2d> b;

  int size() const { return static_cast<int>(a.size()); }
  void Add(const Eigen::Vector2d& in_a, const Eigen::Vector2d& in_b) {
    a.push_back(in_a);
    b.push_back(in_b);
  }
  PointPairs Subset(std::span<const int> rows) const;
};

// x_b = H x_a for homogeneous pixels, with h33 = 1 (or unit norm where h33 is 0).
Eigen::Matrix3d Normalised(const Eigen::Matrix3d& h);

// The image of a point. Infinite or NaN for a point on the line that H sends to infinity.
Eigen::Vector2d Apply(const Eigen::Matrix3d& b_from_a, const Eigen::Vector2d& x_a);

// Whether a point of the plane that image a shows is in front of camera b, where both cameras are
// on the same side of the plane. H maps points behind b, too.
bool IsInFront(const Eigen::Matrix3d& b_from_a, const Eigen::Vector2d& x_a);

// Whether a point lies on the same side of H's horizon (the line sent to infinity) as `inside`: on
// the other side the plane is behind the camera, and the point's image is meaningless.
bool OnSameSide(const Eigen::Matrix3d& b_from_a, const Eigen::Vector2d& x_a,
                const Eigen::Vector2d& inside);

// Mean of the squared transfer errors in both images, px^2: (d(x_b, H x_a)^2 + d(x_a, H^-1
// x_b)^2)/2.
double SymmetricTransferError2(const Eigen::Matrix3d& b_from_a, const Eigen::Matrix3d& a_from_b,
                               const Eigen::Vector2d& x_a, const Eigen::Vector2d& x_b);

// The homography through exactly four pairs, or nothing when three points are nearly in a line (a
// triangle lower than `min_height_ratio` times its longest side) or when their orientation flips
// from one image to the other, which can't happen for a plane seen from one side.
std::optional<Eigen::Matrix3d> HomographyFromFour(std::span<const Eigen::Vector2d, 4> a,
                                                  std::span<const Eigen::Vector2d, 4> b,
                                                  double min_height_ratio);

// Direct linear transform over four or more pairs (Hartley and Zisserman, alg. 4.2, with their
// normalisation), with each pair weighted by its weight (all alike when none are given). Nothing
// when the points don't determine it.
std::optional<Eigen::Matrix3d> HomographyByDlt(const PointPairs& pairs,
                                               std::span<const double> weights = {});

// A homography with its uncertainty.
struct HomographyEstimate {
  Eigen::Matrix3d b_from_a = Eigen::Matrix3d::Identity();  // h33 = 1
  // A square root of the covariance of b_from_a's entries (row by row): b_from_a plus the matrix
  // made of `spread * z`, z eight standard normals, is a homography that the noise could have
  // produced.
  Eigen::Matrix<double, 9, 8> spread = Eigen::Matrix<double, 9, 8>::Zero();
  double sigma_px = 0;  // standard deviation of a transfer error's coordinate
  int pairs = 0;        // from which it was estimated
};

// Least squares on the symmetric transfer error (Hartley and Zisserman, eq. 4.7) by
// Levenberg-Marquardt, from `initial`. Nothing for fewer than five pairs or a singular problem.
std::optional<HomographyEstimate> RefineHomography(const PointPairs& pairs,
                                                   const Eigen::Matrix3d& initial);

// c_from_b composed with an estimate of b_from_a, with the estimate's noise (c_from_b counts as
// exact).
HomographyEstimate Composed(const Eigen::Matrix3d& c_from_b, const HomographyEstimate& b_from_a);

// How far the estimate's noise moves the image of a point: the standard deviation of the distance,
// px in b. Infinite or NaN for a point on the line that is sent to infinity.
double TransferSigma(const HomographyEstimate& b_from_a, const Eigen::Vector2d& x_a);

// A homography drawn from the estimate's distribution; z are eight standard normals.
Eigen::Matrix3d Perturbed(const HomographyEstimate& estimate, const Eigen::Matrix<double, 8, 1>& z);

}  // namespace waystone
