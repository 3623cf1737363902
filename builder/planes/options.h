// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace waystone {

struct PlaneLayerOptions {
  uint64_t seed = 1;

  void Check() const;  // throws MapError(kBadOptions)
};

}  // namespace waystone
