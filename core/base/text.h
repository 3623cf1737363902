// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace waystone {

// Text as HTML shows it, in elements and in attributes with either kind of quotes: & < > " and '
// become character references.
std::string EscapeHtml(std::string_view text);

// `text` as one segment of a URL's path: all but letters, digits and "-._~" as %XX.
std::string EncodeSegment(std::string_view text);

}  // namespace waystone
