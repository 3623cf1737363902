// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "core/base/ids.h"

namespace waystone {

// A surface's colour: always the same for an id, and far from those of the ids around it. Pure;
// thread-safe.
cv::Scalar ColourOf(PlaneId id);      // blue, green, red, 0 to 255
std::string CssColourOf(PlaneId id);  // "#e05a10"

}  // namespace waystone
