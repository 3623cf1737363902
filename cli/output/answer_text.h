// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "api/json.h"

namespace waystone {

// An answer as one line, from the JSON of a server or of ToJson(Answer):
// "q.jpg: localized near rgb/000120.jpg (plane 3, 143 inliers, 69 ms)", and of a query of all maps
// those that weren't searched. Fields that are missing or of another type are left out: a server
// may be of another version.
std::string AnswerLine(const Json& answer);

}  // namespace waystone
