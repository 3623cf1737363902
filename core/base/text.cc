// SPDX-License-Identifier: Apache-2.0
#include "core/base/text.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>

namespace waystone {
namespace {

template <class Number>
std::optional<Number> Parse(std::string_view word) {
  Number value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

// UTF-8 characters that differ only in their last byte.
struct ControlRange {
  std::string_view first;
  char last;
};
constexpr std::array kControls{ControlRange{"\xC2\x80", '\x9F'}, ControlRange{"\xD8\x9C", '\x9C'},
                               ControlRange{"\xE2\x80\x8E", '\x8F'},
                               ControlRange{"\xE2\x80\xA8", '\xAE'},
                               ControlRange{"\xE2\x81\xA6", '\xA9'}};

}  // namespace

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

size_t ControlBytes(std::string_view text) {
  if (text.empty()) return 0;
  const auto byte = static_cast<unsigned char>(text[0]);
  if (byte < 0x20 || byte == 0x7F) return 1;
  const auto found = std::ranges::find_if(kControls, [text](const ControlRange& range) {
    const size_t size = range.first.size();
    return text.size() >= size && text.substr(0, size - 1) == range.first.substr(0, size - 1) &&
           text[size - 1] >= range.first.back() && text[size - 1] <= range.last;
  });
  return found == kControls.end() ? 0 : found->first.size();
}

bool MayBecomeControl(std::string_view text) {
  return std::ranges::any_of(kControls, [text](const ControlRange& range) {
    return text.size() < range.first.size() && range.first.starts_with(text);
  });
}

std::string EscapeControl(std::string_view character) {
  // UTF-8: the leading ones of the first byte say how many bytes follow, each with 6 bits.
  auto code = static_cast<unsigned>(static_cast<unsigned char>(character[0]));
  if (character.size() > 1) code &= 0xFFU >> (character.size() + 1);
  for (const char c : character.substr(1)) {
    code = (code << 6) | (static_cast<unsigned char>(c) & 0x3FU);
  }
  static constexpr std::string_view kHexDigits = "0123456789abcdef";
  std::string text = "\\u";
  for (int shift = 12; shift >= 0; shift -= 4) text += kHexDigits[(code >> shift) & 15];
  return text;
}

std::string Printable(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const size_t control = ControlBytes(text);
    if (control > 0) {
      out += EscapeControl(text.substr(0, control));
    } else {
      out += text[0];
    }
    text.remove_prefix(std::max<size_t>(control, 1));
  }
  return out;
}

std::string_view Trimmed(std::string_view text, std::string_view space) {
  const size_t first = text.find_first_not_of(space);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(space) - first + 1);
}

std::vector<std::string> Words(std::string_view line, std::string_view separators) {
  std::vector<std::string> words;
  while (!line.empty()) {
    const size_t end = std::min(line.find_first_of(separators), line.size());
    if (end > 0) words.emplace_back(line.substr(0, end));
    line.remove_prefix(std::min(end + 1, line.size()));
  }
  return words;
}

std::optional<double> ToNumber(std::string_view word) {
  if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);
  return Parse<double>(word);
}

std::optional<int64_t> ToInteger(std::string_view word) { return Parse<int64_t>(word); }

std::string SizeText(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
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
