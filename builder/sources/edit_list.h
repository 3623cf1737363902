// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace waystone {

// Share of the frames of an MP4 or MOV that its edit list plays: the number in its header includes
// those that were trimmed without encoding again. 1 for other files, and where the list can't be
// read or makes no sense. Internal to builder/sources. Thread-safe.
double PlayedShare(const std::filesystem::path& video);

}  // namespace waystone
