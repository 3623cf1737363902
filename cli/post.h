// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace waystone {

// Posts bytes to a path of a server ("http://127.0.0.1:8080") and returns the answer's body, also
// when it is a problem. Throws MapError(kInternal) when there is no answer.
std::string Post(const std::string& server, const std::string& path,
                 const std::vector<uint8_t>& bytes, const std::string& content_type);

}  // namespace waystone
