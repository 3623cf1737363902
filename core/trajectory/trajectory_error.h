// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "core/base/options.h"
#include "core/geometry/pose2.h"
#include "core/trajectory/shape_difference.h"

namespace waystone {

// A drive on the ground, in order.
struct Trajectory {
  std::vector<double> times_s;  // as many as poses, ascending, or none
  std::vector<Pose2> poses;
  bool has_headings = false;  // whether the poses' angles mean anything
};

struct AssociationOptions {
  double max_difference_s = 0.02;

  static constexpr auto Fields(const auto& use) {
    return use(OptionField{"max_difference_s", &AssociationOptions::max_difference_s,
                           OpenLow(0, 1e9), "s",
                           "Maximum difference between the time stamps of associated poses. Higher "
                           "values associate more poses, but less accurately during fast motion."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// Which pose of the truth (second) belongs to which of the estimate (first): the one with the
// nearest time stamp where both have some, else the one at the same place in the order. Throws
// MapError(kBadSource) when neither gives at least 3 pairs. Pure; thread-safe.
std::vector<std::pair<size_t, size_t>> Associate(const Trajectory& estimate,
                                                 const Trajectory& truth,
                                                 const AssociationOptions& options = {});

// How far an estimate is from the truth.
struct TrajectoryError {
  size_t pairs = 0;
  ShapeDifference shape;
  // Absolute trajectory error (Sturm et al. 2012): the root of the mean squared distance, metres,
  // after rotation and translation only, and with scale and reflection too.
  double ate_m = 0;
  double ate_scaled_m = 0;
  // Relative pose error from one pair to the next, root mean square; nothing without headings.
  std::optional<double> rpe_m;
  std::optional<double> rpe_rad;
};

// Throws what Associate and Align throw. Pure; thread-safe.
TrajectoryError CompareTrajectories(const Trajectory& estimate, const Trajectory& truth,
                                    const AssociationOptions& options = {});

}  // namespace waystone
