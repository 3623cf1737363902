// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace waystone {

// One thing that is wrong with a map.
struct MapProblem {
  std::string where;    // "planes 7", "plane_views 3/12", "file"
  std::string message;  // cause and number
};

}  // namespace waystone
