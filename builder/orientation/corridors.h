// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "builder/orientation/turns.h"
#include "schema/layers/orientation/orientation_layer.h"

namespace waystone {

// Corridors of one sequence (sec. III-C.1): stretches without turns whose heading stays in a range
// and in which, taken together, clearly more lines run along one horizontal axis than along the
// other. Where the motion is known it has to follow that axis. `turns` are indices of confirmed
// turns, ascending. Corridors don't overlap; ordered. Pure; thread-safe.
std::vector<Corridor> FindCorridors(std::span<const OrientationFrame> frames,
                                    std::span<const int> turns,
                                    std::span<const SettledMotion> motions,
                                    const CorridorOptions& options);

}  // namespace waystone
