// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

// Map files among the inputs are kept compressed: most of an SQLite file's pages are empty.
namespace waystone {

std::string Compress(std::string_view bytes);

// Nothing for what zlib didn't write, or what would have more than `max_bytes`.
std::string Decompress(std::string_view bytes, size_t max_bytes);

}  // namespace waystone
