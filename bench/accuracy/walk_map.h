// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "builder/build_map.h"

namespace waystone::bench {

// Where a walk is mapped in two halves, each has this share of it; the two share what is between.
inline constexpr double kHalfShare = 0.6;

// The map of one source by default options, with the version that joining maps asks for.
BuildResult BuildWalk(std::unique_ptr<Source> source, const std::string& name,
                      BuiltFeatures features = BuiltFeatures::kDrop);

}  // namespace waystone::bench
