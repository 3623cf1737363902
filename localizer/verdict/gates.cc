// SPDX-License-Identifier: Apache-2.0
#include "localizer/verdict/gates.h"

namespace waystone {

void GateOptions::Check() const { CheckFields("gates", *this); }

}  // namespace waystone
