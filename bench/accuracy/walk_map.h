// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "builder/build_map.h"

namespace waystone::bench {

// The share of a walk in each of two overlapping halves.
inline constexpr double kHalfShare = 0.6;

// The map of one source, with default options and the version that joining maps requires.
BuildResult BuildWalk(std::unique_ptr<Source> source, const std::string& name,
                      BuiltFeatures features = BuiltFeatures::kDrop);

}  // namespace waystone::bench
