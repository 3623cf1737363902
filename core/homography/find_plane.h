// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/base/options.h"
#include "core/base/random.h"
#include "core/homography/homography.h"
#include "core/homography/neighbourhoods.h"

namespace waystone {

// Matched points of one image (`from`) and of one or two others. Rows i of all belong together. All
// functions here are deterministic; thread-safe (one Random per call).
struct MatchedPoints {
  std::vector<Eigen::Vector2d> from;
  std::vector<Eigen::Vector2d> to;
  // For triple matching: the plane's features in its reference image. Empty otherwise. Errors
  // against it are measured in `from`'s pixels, because far from the reference image its own are
  // stretched.
  std::vector<Eigen::Vector2d> reference;

  int size() const { return static_cast<int>(from.size()); }
};

struct LocalRansacOptions {
  double max_error_px = 2.0;
  double max_sigmas = 4.0;
  double min_error_px = 0.75;
  double confidence = 0.99;
  int max_samples = 1500;
  int neighbourhood = 14;
  double min_height_ratio = 0.05;
  int max_refits = 8;
  int wide_refits = 2;
  double min_refit_share = 0.1;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"max_error_px", &LocalRansacOptions::max_error_px, Above(0), "px",
                    "Maximum transfer error of an inlier. Higher values merge planes that are "
                    "nearly parallel; lower values split walls that are not quite flat."},
        OptionField{"max_sigmas", &LocalRansacOptions::max_sigmas, Above(1), "",
                    "The error bound is tightened to this many standard deviations of the plane's "
                    "own inliers, which separates planes in sharp images."},
        OptionField{"min_error_px", &LocalRansacOptions::min_error_px, Above(0), "px",
                    "The error bound is not tightened below this."},
        OptionField{"confidence", &LocalRansacOptions::confidence, Open(0, 1), "",
                    "p of eq. (1): probability that at least one sample consists of inliers only."},
        OptionField{
            "max_samples", &LocalRansacOptions::max_samples, Closed(1, 100'000), "",
            "Maximum number of samples, however low the inlier ratio; bounds the running time."},
        OptionField{"neighbourhood", &LocalRansacOptions::neighbourhood, AtLeast(3), "",
                    "The three companions of a sampled point are drawn from this many nearest "
                    "neighbours: closer points are more likely to be coplanar, while more distant "
                    "ones determine the homography better."},
        OptionField{"min_height_ratio", &LocalRansacOptions::min_height_ratio, OpenHigh(0, 0.5), "",
                    "Height of a triangle of sampled points, as a share of its longest side, below "
                    "which the points count as collinear."},
        OptionField{"max_refits", &LocalRansacOptions::max_refits, Closed(0, 1000), "",
                    "Maximum number of times a promising sample is refitted to its inliers."},
        OptionField{"wide_refits", &LocalRansacOptions::wide_refits, Closed(0, 1000), "",
                    "Number of initial refits that accept matches up to twice the error bound."},
        OptionField{
            "min_refit_share", &LocalRansacOptions::min_refit_share, Closed(0, 1), "",
            "A sample is refitted if its score is at least this share of the best one so far. "
            "Lower values find larger planes from poor samples, at the cost of time."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// A plane as its homographies: x_to = to_from x_from and x_reference = reference_from x_from.
struct PlaneModel {
  Eigen::Matrix3d to_from = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d reference_from = Eigen::Matrix3d::Identity();  // unused without a reference
};

struct PlaneFit {
  PlaneModel model;
  std::vector<int> inliers;  // rows, ascending
  double score = 0;          // sum of 1 - (error / max_error)^2 over the inliers
  int samples = 0;           // how many were drawn
};

// Squared error of row i under a model, px^2: the symmetric transfer error between `from` and `to`
// and, where there is a reference, the larger of it and the error against the reference.
double PlaneError2(const MatchedPoints& points, const PlaneModel& model, const PlaneModel& inverse,
                   int i);
PlaneModel Inverse(const PlaneModel& model);

// The plane that most of the `active` rows support, by RANSAC over samples of four close,
// non-collinear matches (sec. II) with as many samples as eq. (1) requires and every row supporting
// both homographies (sec. II-A). Nothing when no sample fits four rows.
std::optional<PlaneFit> FindPlane(const MatchedPoints& points, std::span<const int> active,
                                  const Neighbourhoods& neighbourhoods,
                                  const LocalRansacOptions& options, Random& random);

// The same among all rows, with samples from the neighbourhoods of these points.
std::optional<PlaneFit> FindPlane(const MatchedPoints& points, const LocalRansacOptions& options,
                                  uint64_t seed);

// Least-squares refits of a model on its own inliers among the `active` rows until they don't grow.
PlaneFit LocalOptimize(const MatchedPoints& points, std::span<const int> active,
                       const PlaneFit& start, const LocalRansacOptions& options);

// The largest error of an inlier, px, of a plane whose inliers' errors have the standard deviation
// `sigma_px` (per coordinate).
double ErrorBound(double sigma_px, const LocalRansacOptions& options);

}  // namespace waystone
