// SPDX-License-Identifier: Apache-2.0
#include "localizer/orientation/building_options.h"

namespace waystone {

void BuildingOptions::Check() const {
  CheckFields("building", *this);
  segments.Check();
  circles.Check();
  manhattan.Check();
}

}  // namespace waystone
