// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace waystone {

// Text as HTML shows it, in elements and in attributes with either kind of quotes: & < > " and '
// become character references.
std::string EscapeHtml(std::string_view text);

// "\\u001b" for the byte 0x1B: a control character as programs show it.
std::string EscapeControl(unsigned char byte);

// `text` on one line that no terminal obeys: control characters of ASCII and of UTF-8 (U+0080 to
// U+009F), line breaks among them, are escaped.
std::string Printable(std::string_view text);

// `text` as one segment of a URL's path: all but letters, digits and "-._~" as %XX.
std::string EncodeSegment(std::string_view text);

}  // namespace waystone
