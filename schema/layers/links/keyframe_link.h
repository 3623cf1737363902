// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>

#include "core/base/ids.h"

namespace waystone {

// Two keyframes of different visits, of one session or of two, that show one place, though they may
// have no plane in common: one was localized at the other when the map was built or joined.
// FORMAT.md says how they are stored.
struct KeyframeLink {
  KeyframeId a;  // a < b
  KeyframeId b;

  auto operator<=>(const KeyframeLink&) const = default;
};

}  // namespace waystone
