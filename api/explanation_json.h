// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "api/json.h"
#include "localizer/verdict/explanation.h"

namespace waystone {

// Why an answer is what it is: the schema Explanation of clients/openapi.yaml. Matches are
// [x_query, y_query, x_map, y_map], px; inliers are counted at distinct positions. Thread-safe.
Json ToJson(const Explanation& explanation);

}  // namespace waystone
