// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "localizer/verdict/answer.h"

namespace waystone::bench {

// A line for the answer to a query, marked if it is localized but not `right`, and one for each
// place and keyframe of its explanation.
void PrintEvidence(const char* kind, int query, const Answer& answer, bool right);

}  // namespace waystone::bench
