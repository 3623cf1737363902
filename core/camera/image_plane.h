// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/camera/camera.h"

// A camera and its image plane z = 1. All functions are pure and thread-safe.
namespace waystone {

// The point of the image plane that a pixel shows; nothing for a pixel whose ray is nearly
// perpendicular to the optical axis or points backwards, as in an extreme fisheye.
std::optional<Eigen::Vector2d> OnImagePlane(const Camera& camera, const Eigen::Vector2d& pixel);

// The camera's linear part K, px: x_image = K (x, y, 1), apart from distortion. Any camera but an
// equirectangular one (WS_CHECK).
Eigen::Matrix3d ImageFromCamera(const Camera& camera);

// The camera of an image that was resized to `width` px with its aspect ratio kept: focal lengths
// and the principal point scale, (c + 1/2) s - 1/2 as pixel (0, 0) is the middle of the first one;
// distortions don't. `camera` passes CheckCamera.
Camera ScaledCamera(const Camera& camera, int width);

// The angle that a pixel spans at the middle of the image, rad.
double RadiansPerPixel(const Camera& camera);

}  // namespace waystone
