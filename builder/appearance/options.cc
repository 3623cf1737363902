// SPDX-License-Identifier: Apache-2.0
#include "builder/appearance/options.h"

#include "core/base/option_range.h"

namespace waystone {

void AppearanceOptions::Check() const {
  describe.Check();
  odometry.Check();
  loops.Check();
  graph.Check();
  redundancy.Check();
  CheckRange("max_skipped_share", max_skipped_share, 0, 1);
  CheckRange("max_samples", max_samples, 0, 100'000);
}

}  // namespace waystone
