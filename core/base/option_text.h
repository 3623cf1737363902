// SPDX-License-Identifier: Apache-2.0
// Options as text: their values, and the name that was probably meant. All are pure; thread-safe.
#pragma once

#include <charconv>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace waystone {

// A value of an option as ParseOptionValue reads it: "0.8", "true", "sift", "0,2,3"; "none" for an
// unset option. Numbers have the fewest digits that restore them exactly.
inline std::string ToOptionText(bool value) { return value ? "true" : "false"; }
inline std::string ToOptionText(const std::string& value) { return value; }
template <class Value>
requires(std::is_arithmetic_v<Value>) std::string ToOptionText(Value value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof(text), value).ptr};
}
template <class Value>
requires(std::is_enum_v<Value>) std::string ToOptionText(Value value) {
  return std::string(NameOf(value));
}
template <class Value>
std::string ToOptionText(const std::optional<Value>& value) {
  return value ? ToOptionText(*value) : "none";
}
template <class Value>
std::string ToOptionText(const std::vector<Value>& values) {
  std::string text;
  for (const Value& value : values) text += (text.empty() ? "" : ",") + ToOptionText(value);
  return text;
}

// Levenshtein distance: how many letters must be inserted, deleted or replaced to turn one word
// into the other.
size_t EditDistance(std::string_view a, std::string_view b);

// The one of `names` that is nearest to `name` by EditDistance. Empty where none is near: where
// more than a third of the letters would change.
std::string NearestName(std::string_view name, const std::vector<std::string>& names);

}  // namespace waystone
