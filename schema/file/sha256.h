// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace waystone {

// "sha256:<64 hex digits>" of a file's bytes. Throws MapError(kFileUnreadable). Thread-safe.
std::string Sha256OfFile(const std::filesystem::path& path);

}  // namespace waystone
