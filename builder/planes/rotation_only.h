// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "builder/planes/options.h"
#include "core/camera/camera.h"
#include "core/homography/find_plane.h"

namespace waystone {

// Whether two frames differ by a rotation of the camera alone, so that every match fits the one
// homography K R K^-1 and planes can't be told apart (sec. IV). One plane that fills both images
// fits one homography too, but no rotation. The camera's distortion, of any model, is taken out of
// the points first. Where it isn't known, there is taken to be none, the focal length is searched
// and the principal point is the middle of the image (`width` x `height`, px).
bool RotatesOnly(const MatchedPoints& points, int width, int height,
                 const std::optional<Camera>& camera, const RotationOptions& options,
                 const LocalRansacOptions& ransac, uint64_t seed);

}  // namespace waystone
