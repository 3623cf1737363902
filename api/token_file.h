// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace waystone {

// The tokens of a file, one per line; blank lines and those that begin with # are skipped, and
// lines may have Windows line ends. A token has 16 to 512 printable characters. Throws MapError:
// kFileUnreadable; kBadOptions with the line, and for a file of more than 1 MB or without any
// token. Thread-safe.
std::vector<std::string> ReadTokenFile(const std::filesystem::path& path);

}  // namespace waystone
