// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "world/faces.h"
#include "world/world.h"

namespace waystone {

// Where the posters hang: those of the plan's letters, and those the options' chance adds where a
// wall of full height is free. A function of its arguments alone.
std::vector<WorldPoster> HangPosters(const Geometry& geometry, const PlanOptions& size,
                                     const WorldOptions& options);

}  // namespace waystone
