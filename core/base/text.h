// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace waystone {

// Text escaped for HTML elements and attributes with either kind of quotes: & < > " and ' become
// character references. This function and all below are pure; thread-safe.
std::string EscapeHtml(std::string_view text);

// How many bytes at the start of `text`, if any, form a character that controls a terminal instead
// of being shown: ASCII's controls, those of Unicode (U+0080 to U+009F), the ends of lines U+2028
// and U+2029, and what changes the direction of the text after it (U+061C, U+200E, U+200F, U+202A
// to U+202E, U+2066 to U+2069).
size_t ControlBytes(std::string_view text);

// Whether `text` is empty or the incomplete beginning of such a character.
bool MayBecomeControl(std::string_view text);

// "\\u001b" for the byte 0x1B, "\\u202e" for three bytes: a control character as programs show it.
std::string EscapeControl(std::string_view character);

// `text` on one line that is safe to print to a terminal: the characters above are escaped,
// including line breaks.
std::string Printable(std::string_view text);

// `text` without the characters of `space` at its ends.
std::string_view Trimmed(std::string_view text, std::string_view space = " \t\r\n");

// What some editors put in front of UTF-8 text.
inline constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

// Words of a line, separated by any of the `separators`.
std::vector<std::string> Words(std::string_view line, std::string_view separators = " \t\r");

// The number that `word` as a whole spells, or nothing. Independent of the locale. A double may be
// infinite or NaN.
std::optional<double> ToNumber(std::string_view word);
std::optional<int64_t> ToInteger(std::string_view word);

// "640x480".
std::string SizeText(int width, int height);

// `text` as one segment of a URL's path: everything but letters, digits and "-._~" as %XX.
std::string EncodeSegment(std::string_view text);

}  // namespace waystone
