// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "localizer/answer.h"

namespace waystone {

// The answer when the deadline passed after `stage` (Answer::stage), still without the map's name.
Answer Undecided(const std::string& stage);

}  // namespace waystone
