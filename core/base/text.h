// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace waystone {

// Text as HTML shows it, in elements and in attributes with either kind of quotes: & < > " and '
// become character references.
std::string EscapeHtml(std::string_view text);

}  // namespace waystone
