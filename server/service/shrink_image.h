// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

namespace waystone {

// Whether a map's picture is wider than `width` px, by its header. Throws MapError(kBadImage).
// Pure; thread-safe.
bool IsWider(const std::vector<uint8_t>& picture, int width);

// A JPEG of a picture that is wider than that, shrunk to `width` px in proportion. Takes up to 250
// MB. Deterministic; thread-safe. Throws MapError: kBadImage, and kNotAvailable for a picture that
// takes more to decode than those that builds store, of up to 24 megapixels.
std::vector<uint8_t> ShrunkPicture(const std::vector<uint8_t>& picture, int width);

}  // namespace waystone
