// SPDX-License-Identifier: Apache-2.0
#include "builder/build_options.h"

#include <string>

#include "core/base/error.h"

namespace waystone {

void BuildOptions::Check() const {
  CheckFields("", *this);
  features.Check();
  keyframes.Check();
  planes.Check();
  appearance.Check();
  orientation.Check();
  calibration.Check();
  appearance_calibration.Check();
  if (threads < 0 || threads > 1024) {
    throw MapError(ErrorCode::kBadOptions, "threads is " + std::to_string(threads) +
                                               "; it must be between 0 (one per core) and 1024");
  }
}

}  // namespace waystone
