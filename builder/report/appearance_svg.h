// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "schema/layers/appearance/appearance_layer.h"

namespace waystone {

// The trajectory of a layer's panoramas from above, x to the right, y up, with its loops, as one
// <svg>. Pure; thread-safe.
std::string AppearanceSvg(const AppearanceLayer& layer);

}  // namespace waystone
