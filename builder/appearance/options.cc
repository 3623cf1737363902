// SPDX-License-Identifier: Apache-2.0
#include "builder/appearance/options.h"

namespace waystone {

void AppearanceOptions::Check() const {
  CheckFields("appearance", *this);
  describe.Check();
  odometry.Check();
  graph.Check();
}

}  // namespace waystone
