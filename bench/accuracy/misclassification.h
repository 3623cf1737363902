// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace waystone::bench {

// The share of rows with wrong labels, under the one-to-one assignment of found planes to true ones
// that makes this share smallest. Labels are 0 for no plane, which stays 0, and 1, 2, ... for
// planes. At most 20 true planes.
double Misclassification(const std::vector<int>& truth, const std::vector<int>& found);

}  // namespace waystone::bench
