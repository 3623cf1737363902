// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace waystone {

// Text as HTML shows it, in elements and in attributes with either kind of quotes: & < > " and '
// become character references.
std::string EscapeHtml(std::string_view text);

// How many bytes at the start of `text`, if any, are a character that acts on a terminal instead of
// being shown: ASCII's controls, those of Unicode (U+0080 to U+009F), the ends of lines U+2028 and
// U+2029, and what changes the direction of the text behind it (U+061C, U+200E, U+200F, U+202A to
// U+202E, U+2066 to U+2069).
size_t ControlBytes(std::string_view text);

// Whether `text` is empty or the beginning of a longer character of those.
bool MayBecomeControl(std::string_view text);

// "\\u001b" for the byte 0x1B, "\\u202e" for three bytes: a control character as programs show it.
std::string EscapeControl(std::string_view character);

// `text` on one line that no terminal obeys: the characters above are escaped, line breaks among
// them.
std::string Printable(std::string_view text);

// `text` without the characters of `space` at its ends.
std::string_view Trimmed(std::string_view text, std::string_view space = " \t\r\n");

// Words of a line, separated by any of the `separators`.
std::vector<std::string> Words(std::string_view line, std::string_view separators = " \t\r");

// The number that is all of `word`, or nothing. Independent of the locale. A double may be infinite
// or not a number.
std::optional<double> ToNumber(std::string_view word);
std::optional<int64_t> ToInteger(std::string_view word);

// "640x480".
std::string SizeText(int width, int height);

// `text` as one segment of a URL's path: all but letters, digits and "-._~" as %XX.
std::string EncodeSegment(std::string_view text);

}  // namespace waystone
