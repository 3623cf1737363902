// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "schema/map_data.h"
#include "schema/tables/map_problem.h"

namespace waystone {

// Everything that is wrong with a map as values: numbers, order and references. The same rules hold
// before writing, when reading and in CheckMap; FORMAT.md lists them. Pure; thread-safe.
std::vector<MapProblem> FindMapProblems(const MapData& map);

}  // namespace waystone
