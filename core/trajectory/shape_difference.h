// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

namespace waystone {

using Points2 = std::vector<Eigen::Vector2d>;

// x_a = scale * rotation * x_b + translation for a similarity named a_from_b.
struct Similarity2 {
  double scale = 1;
  Eigen::Matrix2d rotation = Eigen::Matrix2d::Identity();  // orthogonal; -1 as its determinant
                                                           // means that it reflects
  Eigen::Vector2d translation = Eigen::Vector2d::Zero();

  Eigen::Vector2d operator*(const Eigen::Vector2d& x) const {
    return scale * (rotation * x) + translation;
  }
};

// What an alignment may do besides turning and shifting.
struct AlignmentOptions {
  bool scale = true;    // the paper's maps know no metres ...
  bool reflect = true;  // ... and may be mirrored
};

// The alignment with the least sum of squared distances |truth - truth_from_estimate * estimate|,
// in closed form by the singular values of the covariance (Seber 1984; Umeyama 1991). Throws
// MapError(kBadSource) for fewer than 3 pairs, different numbers of points, points that aren't
// finite (or are beyond 1e100), or points that all coincide. Pure; thread-safe.
Similarity2 Align(const Points2& truth, const Points2& estimate,
                  const AlignmentOptions& options = {});

// The shape difference of Fernandez et al. 2011 (sec. IV-B): Procrustes analysis with scale,
// rotation and reflection.
struct ShapeDifference {
  double mu = 0;  // 0 the same shape, 1 nothing in common: the share of the truth's spread that the
                  // aligned estimate doesn't explain
  Similarity2 truth_from_estimate;
  Points2 aligned;  // the estimate in the truth's frame
};

// Throws what Align throws. Pure; thread-safe.
ShapeDifference CompareShapes(const Points2& truth, const Points2& estimate);

}  // namespace waystone
