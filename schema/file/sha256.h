// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <string>

namespace waystone {

// "sha256:<64 hex digits>" of the bytes. Thread-safe.
std::string Sha256(std::span<const unsigned char> bytes);

// The same of a file's bytes, of which 1 MB is in memory at a time. Throws
// MapError(kFileUnreadable). Thread-safe.
std::string Sha256OfFile(const std::filesystem::path& path);

// Whether `text` is such a hash. Thread-safe.
bool IsSha256(const std::string& text);

}  // namespace waystone
