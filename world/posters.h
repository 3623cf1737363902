// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "world/faces.h"
#include "world/world.h"

namespace waystone {

// Where the posters hang: those of the plan's letters, and those added at random
// (poster_probability) where a wall of full height is free. Pure; thread-safe.
std::vector<WorldPoster> HangPosters(const Geometry& geometry, const PlanOptions& size,
                                     const WorldOptions& options);

}  // namespace waystone
