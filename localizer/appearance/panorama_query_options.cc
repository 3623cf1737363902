// SPDX-License-Identifier: Apache-2.0
#include "localizer/appearance/panorama_query_options.h"

namespace waystone {

void PanoramaQueryOptions::Check() const {
  CheckFields("panorama", *this);
  phases.Check();
  compass.Check();
  features.Check();
  relative.Check();
}

}  // namespace waystone
