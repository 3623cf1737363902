// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/features/features.h"

namespace waystone {

// The default of `features.working_pixels` for a type of features. BuildOptions has that of SIFT,
// which also looks at an image of twice the size where a plain one gives too little; ORB and AKAZE
// don't, and find less in so few pixels (docs/design.md).
int WorkingPixelsFor(FeatureType type);

}  // namespace waystone
