// SPDX-License-Identifier: Apache-2.0
#include "builder/orientation/options.h"

namespace waystone {

void FollowOptions::Check() const { CheckFields("follow", *this); }

void TurnOptions::Check() const { CheckFields("turns", *this); }

void CorridorOptions::Check() const { CheckFields("corridors", *this); }

void OrientationLoopOptions::Check() const { CheckFields("loops", *this); }

void TraversabilityOptions::Check() const {
  CheckFields("traversability", *this);
  relative.Check();
}

void OrientationOptions::Check() const {
  CheckFields("orientation", *this);
  segments.Check();
  circles.Check();
  manhattan.Check();
  bearings.Check();
  traversability.Check();
}

}  // namespace waystone
