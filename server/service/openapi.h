// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

// The contract of the HTTP API, clients/openapi.yaml, which is built into the program. Thread-safe.
namespace waystone {

// The contract as JSON.
const std::string& OpenApiJson();
// The contract for people: self-contained HTML, no scripts.
const std::string& OpenApiPage();

// The Content-Security-Policy of our pages: their own styles and nothing else.
inline constexpr char kPagePolicy[] =
    "default-src 'none'; style-src 'unsafe-inline'; frame-ancestors 'none'";

}  // namespace waystone
