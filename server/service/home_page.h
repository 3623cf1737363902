// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace waystone {

// The page at "/plain": which maps there are and how to query them. Self-contained HTML, no
// scripts. `host` is HOST or HOST:PORT, as clients reach the server. Pure; thread-safe.
std::string HomePage(const std::vector<std::string>& map_names, const std::string& host);

}  // namespace waystone
