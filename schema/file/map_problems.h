// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "schema/file/map_store.h"
#include "schema/map_data.h"

namespace waystone {

// How exact stored geometry has to be.
struct SoundnessLimits {
  // Condition number of a homography with pixels scaled by the image's size. Beyond it the inverse
  // keeps too few digits to map pixels back.
  double max_condition = 1e8;
  // Deviation, relative to 1 or to the value, of a homology's double eigenvalue from 1 and of its
  // third one from what is stored. Measured homologies are noisy: their double eigenvalue is a
  // pair, and the square of its distance is allowed on top.
  double eigenvalue_tolerance = 1e-3;
};

// Everything that is wrong with a map as values: numbers, order and references. The same rules hold
// before writing, when reading and in CheckMap; FORMAT.md lists them. Pure; thread-safe.
std::vector<MapProblem> FindMapProblems(const MapData& map, const SoundnessLimits& limits = {});

}  // namespace waystone
