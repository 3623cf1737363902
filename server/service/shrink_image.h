// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

namespace waystone {

// A JPEG at most `width` pixels wide, with its shape; the bytes themselves when they are no wider.
// Deterministic; thread-safe. Throws MapError(kBadImage).
std::vector<uint8_t> ShrunkJpeg(const std::vector<uint8_t>& jpeg, int width);

}  // namespace waystone
