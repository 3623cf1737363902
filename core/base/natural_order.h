// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace waystone {

// img2 before img10: digits are compared as numbers, the rest byte by byte; a folder's files come
// before those of a folder whose name is longer ("a/x" before "a b/x"). A strict weak order. Pure;
// thread-safe.
bool NaturalLess(std::string_view a, std::string_view b);

}  // namespace waystone
