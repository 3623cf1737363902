// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <vector>

#include "core/base/options.h"
#include "core/features/features.h"
#include "core/features/packed_rows.h"

namespace waystone {

// Descriptor i of one set and descriptor j of another that look alike.
struct Match {
  int a = 0;
  int b = 0;
  int distance = 0;  // of the descriptors, in the unit of distance.h

  bool operator==(const Match&) const = default;
};

struct MatchOptions {
  double max_ratio = 0.8;
  bool mutual = true;

  static constexpr auto Fields(const auto& use) {
    return use(OptionField{"max_ratio", &MatchOptions::max_ratio, OpenLow(0, 1), "",
                           "Maximum ratio of the nearest to the second-nearest distance (Lowe's "
                           "ratio test; Euclidean distances for SIFT, Hamming distances for the "
                           "others). Higher values find more matches, but also more wrong ones."},
               OptionField{"mutual", &MatchOptions::mutual, AnyValue(), "",
                           "Keep a match only if each feature is the other's nearest neighbour."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// Matches a's descriptors among b's by exact search; ordered by a. Both of one type.
// Deterministic (ties go to the lower index); thread-safe.
std::vector<Match> MatchDescriptors(DescriptorsView a, DescriptorsView b, FeatureType type,
                                    const MatchOptions& options);

// The same with one side already packed, for callers that match it more than once.
std::vector<Match> MatchDescriptors(const PackedRows& a, int a_rows, DescriptorsView b,
                                    const MatchOptions& options);

// The ratio of the Euclidean or Hamming distances, given in the unit of distance.h. `farther` isn't
// 0.
double DistanceRatio(FeatureType type, int nearer, int farther);

// Whether `nearest` passes the ratio test against `second` (distances in the unit of distance.h).
bool PassesRatio(FeatureType type, int nearest, int second, double max_ratio);

// A row of a block and its distance to a query.
struct Neighbour {
  int row = -1;
  int distance = std::numeric_limits<int>::max();
};

}  // namespace waystone
