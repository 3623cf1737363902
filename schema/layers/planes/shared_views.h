// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "schema/layers/planes/plane_layer.h"

namespace waystone {

// Two planes in a keyframe that saw both. Points into the planes.
struct SharedView {
  const PlaneView* of_m = nullptr;
  const PlaneView* of_n = nullptr;
};

// The views that two planes share, by keyframe: at most 20, spread over all, since a camera that
// stands still sees the same two planes thousands of times. Pure; thread-safe.
std::vector<SharedView> SharedViews(const Plane& m, const Plane& n);

}  // namespace waystone
