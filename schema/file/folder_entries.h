// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace waystone {

// The names of a folder's entries, in no order. Throws std::filesystem::filesystem_error where it
// can't be read, and std::bad_alloc, where std::filesystem::directory_iterator would end the
// program. Thread-safe.
std::vector<std::string> FolderEntries(const std::filesystem::path& folder);

}  // namespace waystone
