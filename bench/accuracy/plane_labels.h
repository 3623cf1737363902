// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "builder/planes/options.h"
#include "core/homography/segment_planes.h"

namespace waystone::bench {

// Label of each match by the planes that the builder finds in two images: 1 + index of its plane, 0
// for none.
std::vector<int> LabelPlanes(const MatchedPoints& points, const PlaneLayerOptions& options);

}  // namespace waystone::bench
