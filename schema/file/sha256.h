// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

namespace waystone {

// "sha256:<64 hex digits>" of the bytes. Thread-safe.
std::string Sha256(std::span<const unsigned char> bytes);

}  // namespace waystone
