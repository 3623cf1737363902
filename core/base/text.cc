// SPDX-License-Identifier: Apache-2.0
#include "core/base/text.h"

#include <cctype>

namespace waystone {

std::string EscapeHtml(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string EscapeControl(unsigned char byte) {
  static constexpr std::string_view kHexDigits = "0123456789abcdef";
  return {'\\', 'u', '0', '0', kHexDigits[byte >> 4], kHexDigits[byte & 15]};
}

std::string Printable(std::string_view text) {
  constexpr unsigned char kC1Lead = 0xC2;  // U+0080 to U+009F are C2 80 to C2 9F
  std::string out;
  for (size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const auto next = static_cast<unsigned char>(i + 1 < text.size() ? text[i + 1] : 0);
    if (byte == kC1Lead && next >= 0x80 && next < 0xA0) {
      out += EscapeControl(next);
      ++i;
    } else if (byte < 0x20 || byte == 0x7F) {
      out += EscapeControl(byte);
    } else {
      out += text[i];
    }
  }
  return out;
}

std::string EncodeSegment(std::string_view text) {
  static constexpr std::string_view kHex = "0123456789ABCDEF";
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if ((std::isalnum(byte) != 0 && byte < 128) ||
        std::string_view("-._~").find(c) != std::string_view::npos) {
      out += c;
    } else {
      out += {'%', kHex[byte >> 4], kHex[byte & 15]};
    }
  }
  return out;
}

}  // namespace waystone
