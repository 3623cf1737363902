// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "core/base/options.h"
#include "core/homography/homography.h"

namespace waystone {

// What the eigenvalues of a homology say about two planes (planar region graph, sec. II-B).
enum class HomologyKind {
  kSamePlane,  // all three near one: the homology is the identity
  kTwoPlanes,  // two near one: (1, 1, 1 + v^T p) of eqs. (2) and (3)
  kInvalid,    // fewer: one of the two homographies doesn't describe a plane
};

struct HomologyOptions {
  double max_sigmas = 4.0;
  int independent = 40;
  int draws = 40;
  uint64_t seed = 1;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"max_sigmas", &HomologyOptions::max_sigmas, Above(0), "",
                    "Number of standard deviations by which an eigenvalue may differ from 1 and "
                    "still count as 1. Higher values accept more false planes; lower values reject "
                    "more true ones."},
        OptionField{"independent", &HomologyOptions::independent, AtLeast(5), "",
                    "Number of matches of a plane that count as independent measurements: errors "
                    "shared by neighbours (lens distortion, uneven walls) don't average out over "
                    "more. Lower values accept more planes, both true and false ones."},
        OptionField{"draws", &HomologyOptions::draws, Closed(10, 10'000), "",
                    "Number of samples from which the standard deviations of the eigenvalues are "
                    "estimated."},
        OptionField{"seed", &HomologyOptions::seed, AnyValue(), "",
                    "Random seed of these samples."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

struct Homology {
  HomologyKind kind = HomologyKind::kInvalid;
  // H^{mn} = (H^m)^-1 H^n, scaled so that the mean of its closest pair of eigenvalues is 1.
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  double third_eigenvalue = 1;  // 1 + v^T p
  double split = 0;             // distance of the closest pair of eigenvalues
  double split_sigma = 0;       // standard deviation of `split` for a true pair of planes
  // Standard deviation of `third_eigenvalue` for one and the same plane; 0 for kInvalid.
  double third_sigma = 0;
};

// Eigenvalue test of two planes seen in the same two images: m and n are both estimated from the
// same image a to the same image b. The tolerances are the spread of the eigenvalues under the
// homographies' own measured noise; that of `split` counts at most `independent` matches of each.
// Deterministic; thread-safe.
Homology TestHomology(const HomographyEstimate& m, const HomographyEstimate& n,
                      const HomologyOptions& options);

// Whether TestHomology would return anything but kInvalid, without the draws for the third
// eigenvalue. Deterministic; thread-safe.
bool HaveHomology(const HomographyEstimate& m, const HomographyEstimate& n,
                  const HomologyOptions& options);

// The closest pair of eigenvalues and the third one, from the homology's matrix only.
struct HomologyEigenvalues {
  double scale = 1;  // mean of the closest pair
  double split = 0;  // distance of the closest pair, in units of `scale`
  double third = 1;  // in units of `scale`
};
HomologyEigenvalues ComputeEigenvalues(const Eigen::Matrix3d& homology);

}  // namespace waystone
