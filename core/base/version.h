// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace waystone {

// The program's version; CMakeLists.txt reads it from here.
inline constexpr char kVersion[] = "0.1.0";

}  // namespace waystone
