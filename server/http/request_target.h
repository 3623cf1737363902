// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

// What a request asks for, from a target that starts with its path: "/v1/maps?limit=5". Internal to
// server/http. Pure; thread-safe.
namespace waystone {

// The path, percent-decoded, but for slashes within a segment ("%2F") and percent signs ("%25"), so
// that equivalent paths are the same (RFC 3986, sections 2.2 and 2.4).
std::string PathOf(std::string_view target);

// The segments of such a path, completely decoded: {"a", "b/c"} of "/a/b%2Fc", and {} of "/". An
// empty segment inside ("/a//b") stays.
std::vector<std::string> SegmentsOf(std::string_view path);

// The fields after the path, percent-decoded, with '+' for a space; each name ends at its first
// '='. Throws MapError(kBadRequest) for a field that is given twice and for a value without a name.
std::map<std::string, std::string> QueryOf(std::string_view target);

}  // namespace waystone
