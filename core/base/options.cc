// SPDX-License-Identifier: Apache-2.0
#include "core/base/options.h"

#include <charconv>
#include <cmath>
#include <cstdint>
#include <sstream>
#include <type_traits>

namespace waystone {
namespace {

std::string Number(double value) {
  std::ostringstream out;
  out.precision(9);
  out << value;
  return out.str();
}

template <class Value>
void ParseNumber(const std::string& path, const std::string& text, const char* kind, Value* value) {
  const char* end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, *value);
  bool is_number = error == std::errc() && at == end;
  if constexpr (std::is_floating_point_v<Value>) is_number = is_number && std::isfinite(*value);
  if (is_number) return;
  throw MapError(ErrorCode::kBadOptions, path + " is '" + text + "'; it must be " + kind);
}

}  // namespace

std::string ToText(const OptionRange& range) {
  const bool low = std::isfinite(range.low);
  const bool high = std::isfinite(range.high);
  if (low && high && !range.low_open && !range.high_open) {
    return "between " + Number(range.low) + " and " + Number(range.high);
  }
  std::string text;
  if (low) text = (range.low_open ? "above " : "at least ") + Number(range.low);
  if (high) {
    text += (text.empty() ? "" : " and ") + std::string(range.high_open ? "below " : "at most ") +
            Number(range.high);
  }
  return text.empty() ? "any number" : text;
}

namespace options_internal {

void ThrowOutOfRange(const std::string& path, double value, const OptionRange& range,
                     std::string_view unit) {
  throw MapError(ErrorCode::kBadOptions, path + " is " + Number(value) + "; it must be " +
                                             ToText(range) +
                                             (unit.empty() ? "" : " " + std::string(unit)));
}

}  // namespace options_internal

void ParseOptionValue(const std::string& path, const std::string& text, bool* value) {
  if (text != "true" && text != "false") {
    throw MapError(ErrorCode::kBadOptions, path + " is '" + text + "'; it must be true or false");
  }
  *value = text == "true";
}

void ParseOptionValue(const std::string& path, const std::string& text, int* value) {
  ParseNumber(path, text, "a whole number", value);
}

void ParseOptionValue(const std::string& path, const std::string& text, int64_t* value) {
  ParseNumber(path, text, "a whole number", value);
}

void ParseOptionValue(const std::string& path, const std::string& text, uint64_t* value) {
  ParseNumber(path, text, "a whole number, 0 or more", value);
}

void ParseOptionValue(const std::string& path, const std::string& text, float* value) {
  ParseNumber(path, text, "a finite number", value);
}

void ParseOptionValue(const std::string& path, const std::string& text, double* value) {
  ParseNumber(path, text, "a finite number", value);
}

void ParseOptionValue(const std::string&, const std::string& text, std::string* value) {
  *value = text;
}

void ParseOptionValue(const std::string& path, const std::string& text,
                      std::vector<double>* value) {
  value->clear();
  std::istringstream numbers(text);
  for (std::string number; std::getline(numbers, number, ',');) {
    ParseOptionValue(path, number, &value->emplace_back());
  }
}

}  // namespace waystone
