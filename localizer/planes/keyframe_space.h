// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/camera/camera.h"
#include "core/homography/plane_in_space.h"
#include "localizer/index/map_index.h"

namespace waystone {

// A plane of the map and a view of it.
struct PlaneInView {
  const Plane* plane;
  const PlaneView* view;
};

// The planes that a keyframe sees, in space, in its camera's frame (x right, y down, z forward).
// Points into the index.
struct KeyframeSpace {
  Camera camera;
  std::vector<PlaneInView> planes;  // that the keyframe sees, by id
  int views = 0;                    // other keyframes used
  SpaceEstimate estimate;           // of `planes`
};

// Puts the planes of a keyframe into space by their stored homographies to the other keyframes that
// share most of them (core/homography/plane_in_space). Throws MapError(kNotAvailable) for a
// sequence without a camera and for panoramas. Takes up to some 100 ms. Pure; thread-safe.
KeyframeSpace EstimateSpace(const MapIndex& index, const Keyframe& keyframe);

}  // namespace waystone
