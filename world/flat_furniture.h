// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/random.h"
#include "world/flat.h"

namespace waystone {

// Puts furniture, pictures and a lamp into a room of a flat. What stands on the floor keeps away
// from `kept_free` and from the rest. Thread-safe for different scenes and generators.
struct FreeCircle {
  Eigen::Vector2d at = Eigen::Vector2d::Zero();
  double radius_m = 0;
};
void FurnishRoom(RoomScene& scene, int room, int pieces, const std::vector<FreeCircle>& kept_free,
                 Random& random);

// Whether a circle touches no box that extends between two heights. Pure; thread-safe.
bool IsClear(const RoomScene& scene, const Eigen::Vector2d& at, double radius_m, double low_m,
             double high_m);

}  // namespace waystone
