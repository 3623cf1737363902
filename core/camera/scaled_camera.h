// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/camera/camera.h"

namespace waystone {

// The camera of an image that was resized to `width` px, its shape kept: focal lengths and the
// principal point scale, (c + 1/2) s - 1/2 as pixel (0, 0) is the middle of the first one;
// distortions don't. `camera` passes CheckCamera. Pure; thread-safe.
Camera ScaledCamera(const Camera& camera, int width);

}  // namespace waystone
