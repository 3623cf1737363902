// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "localizer/localizer.h"
#include "localizer/planes/image_features.h"

namespace waystone {

// LocalizeAcross with features of the image that were extracted before; newly extracted ones are
// added. `features` belongs to this image only. Thread-safe for different `features`.
std::vector<Answer> LocalizeAcross(const std::vector<const MapIndex*>& maps,
                                   std::span<const uint8_t> bytes, const std::string& name,
                                   const LocalizeOptions& options, ImageFeatures& features);

}  // namespace waystone
