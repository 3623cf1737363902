// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "api/json.h"

namespace waystone {

// An answer of one map in a line, as a server or ToJson(Answer) gives it:
// "q.jpg: localized near rgb/000120.jpg (plane 3, 143 inliers, 69 ms)". Fields that are missing or
// of another kind are left out: a server may be of another version.
std::string AnswerLine(const Json& answer);

}  // namespace waystone
