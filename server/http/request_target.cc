// SPDX-License-Identifier: Apache-2.0
#include "server/http/request_target.h"

#include <algorithm>
#include <charconv>

#include "api/query_request_json.h"

namespace waystone {
namespace {

// A '%' without two hexadecimal digits stays as it is.
std::string Decoded(std::string_view text, bool plus_is_space) {
  std::string out;
  for (size_t i = 0; i < text.size(); ++i) {
    unsigned char byte = 0;
    const std::string_view digits = text[i] == '%' ? text.substr(i + 1, 2) : std::string_view();
    const auto [end, error] =
        std::from_chars(digits.data(), digits.data() + digits.size(), byte, 16);
    if (digits.size() == 2 && error == std::errc() && end == digits.data() + 2) {
      out += static_cast<char>(byte);
      i += 2;
    } else {
      out += plus_is_space && text[i] == '+' ? ' ' : text[i];
    }
  }
  return out;
}

// A decoded segment, as it is in a path.
std::string Escaped(const std::string& segment) {
  std::string out;
  for (const char c : segment) {
    if (c == '/') {
      out += "%2F";
    } else if (c == '%') {
      out += "%25";
    } else {
      out += c;
    }
  }
  return out;
}

// Browsers don't send what follows a '#'.
std::string_view WithoutFragment(std::string_view target) {
  return target.substr(0, target.find('#'));
}

}  // namespace

std::string PathOf(std::string_view target) {
  target = WithoutFragment(target);
  target = target.substr(0, target.find('?'));
  std::string path;
  while (true) {
    const size_t end = std::min(target.find('/'), target.size());
    path += Escaped(Decoded(target.substr(0, end), false));
    if (end == target.size()) return path;
    path += '/';
    target.remove_prefix(end + 1);
  }
}

std::vector<std::string> SegmentsOf(std::string_view path) {
  std::vector<std::string> segments;
  if (path.size() <= 1) return segments;
  size_t start = 1;
  while (true) {
    const size_t end = path.find('/', start);
    segments.push_back(Decoded(path.substr(start, end - start), false));
    if (end == std::string_view::npos) return segments;
    start = end + 1;
  }
}

std::map<std::string, std::string> QueryOf(std::string_view target) {
  std::map<std::string, std::string> query;
  std::string_view rest = WithoutFragment(target);
  rest.remove_prefix(std::min(rest.find('?'), rest.size()));
  while (!rest.empty()) {
    rest.remove_prefix(1);  // '?' or '&'
    const std::string_view field = rest.substr(0, rest.find('&'));
    rest.remove_prefix(field.size());
    if (field.empty()) continue;
    const size_t equals = std::min(field.find('='), field.size());
    const std::string name = Decoded(field.substr(0, equals), true);
    if (name.empty()) {
      RefuseRequest("the URL has a value without a name, " + QuoteShortened(std::string(field)) +
                    "; fields are NAME=VALUE");
    }
    const std::string value = Decoded(field.substr(std::min(equals + 1, field.size())), true);
    if (!query.emplace(name, value).second) {
      RefuseRequest("the URL has the field " + QuoteShortened(name) +
                    " more than once; give it once");
    }
  }
  return query;
}

}  // namespace waystone
