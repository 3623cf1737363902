// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace waystone {

// The page at "/plain": which maps there are and how to ask them. Self-contained HTML, no scripts.
std::string HomePage(const std::vector<std::string>& map_names, const std::string& host);

}  // namespace waystone
