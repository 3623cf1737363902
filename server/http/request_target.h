// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <string_view>

// What a request asks for, from a target that starts with its path: "/v1/maps?limit=5". Internal to
// server/http. Pure; thread-safe.
namespace waystone {

// The path, percent-decoded.
std::string PathOf(std::string_view target);

// The fields after the path, percent-decoded, with '+' for a space; each name ends at its first
// '='. Throws MapError(kBadRequest) for a field that is given twice and for a value without a name.
std::map<std::string, std::string> QueryOf(std::string_view target);

}  // namespace waystone
