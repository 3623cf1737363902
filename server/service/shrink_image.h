// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

namespace waystone {

// A JPEG of a map's picture, at most `width` px wide and of the same shape; the picture itself if
// it is no wider. Deterministic; thread-safe. Throws MapError(kBadImage).
std::vector<uint8_t> ShrunkPicture(const std::vector<uint8_t>& picture, int width);

}  // namespace waystone
