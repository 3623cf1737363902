// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "schema/map_data.h"

namespace waystone {

// Where to draw each of the map's planes, in their order, in [0, 1] x [0, 1]: neighbours near each
// other. The same map gives the same picture.
std::vector<Eigen::Vector2d> LayOutGraph(const MapData& map);

}  // namespace waystone
