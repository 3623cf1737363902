// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

namespace waystone {

// Whether a map's picture is wider, by its header. Throws MapError(kBadImage).
bool IsWider(const std::vector<uint8_t>& picture, int width);

// A JPEG of a picture that is wider, `width` px wide and of the same shape. Takes up to 250 MB.
// Deterministic; thread-safe. Throws MapError: kBadImage, and kNotAvailable for a picture that is
// larger than builds store them: over 24 megapixels.
std::vector<uint8_t> ShrunkPicture(const std::vector<uint8_t>& picture, int width);

}  // namespace waystone
