// SPDX-License-Identifier: Apache-2.0
#include "core/homography/estimate_homography.h"

#include <utility>

namespace waystone {

std::optional<PlaneEstimate> EstimateHomography(const MatchedPoints& matches,
                                                const LocalRansacOptions& options, uint64_t seed) {
  auto fit = FindPlane(matches, options, seed);
  if (!fit) return std::nullopt;
  PointPairs pairs;
  for (const int row : fit->inliers) pairs.Add(matches.from[row], matches.to[row]);
  const auto to_from = RefineHomography(pairs, fit->model.to_from);
  if (!to_from) return std::nullopt;
  PlaneEstimate estimate{*to_from, {}, std::move(fit->inliers)};
  if (matches.reference.empty()) return estimate;
  for (int i = 0; i < pairs.size(); ++i) pairs.b[i] = matches.reference[estimate.inliers[i]];
  const auto reference_from = RefineHomography(pairs, fit->model.reference_from);
  if (!reference_from) return std::nullopt;
  estimate.reference_from = *reference_from;
  return estimate;
}

}  // namespace waystone
