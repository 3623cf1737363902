// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "builder/planes/options.h"
#include "core/camera/camera.h"
#include "core/homography/find_plane.h"

namespace waystone {

// Whether two frames differ only by a rotation of the camera, so that every match fits the one
// homography K R K^-1 and planes can't be distinguished (sec. IV). One plane that fills both images
// fits one homography too, but no rotation. The distortion of `camera`, of any model, is removed
// from the points first. Without a camera, no distortion is assumed, the focal length is searched
// for, and the principal point is the middle of the image (`width` x `height`, px). Deterministic;
// thread-safe.
bool RotatesOnly(const MatchedPoints& points, int width, int height,
                 const std::optional<Camera>& camera, const RotationOptions& options,
                 const LocalRansacOptions& ransac, uint64_t seed);

}  // namespace waystone
