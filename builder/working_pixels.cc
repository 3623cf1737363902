// SPDX-License-Identifier: Apache-2.0
#include "builder/working_pixels.h"

#include "builder/build_options.h"

namespace waystone {

int WorkingPixelsFor(FeatureType type) {
  const int of_sift = BuildOptions{}.features.working_pixels;
  return type == FeatureType::kSift ? of_sift : 2 * of_sift;
}

}  // namespace waystone
