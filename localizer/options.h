// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "core/features/features.h"
#include "core/image/decode.h"

namespace waystone {

struct LocalizeOptions {
  DecodeLimits limits;
  // Features taken from a query; their type is the map's.
  int max_features = 1000;
  double contrast_threshold = 0.02;  // as FeatureOptions'
  // Planes whose homography is tried, best voted first. More find more and cost about 1 ms each.
  int max_candidates = 12;
  // Seed of the sampling: the same query, map and options give the same answer.
  uint64_t seed = 1;

  void Check() const;  // throws MapError(kBadOptions)
};

}  // namespace waystone
