// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/base/options.h"

// The record of the options that a map was built with. All functions are thread-safe.
namespace waystone {

struct BuildOptions;

namespace options_record_internal {

template <class Value>
concept Enumeration = std::is_enum_v<Value>;

// Values of options as JSON.
std::string ToJson(bool value);
std::string ToJson(double value);
std::string ToJson(std::string_view value);
template <std::integral Value>
std::string ToJson(Value value) {
  return std::to_string(value);
}
template <Enumeration Value>
std::string ToJson(Value value) {
  return ToJson(std::string_view(NameOf(value)));
}
template <class Value>
std::string ToJson(const std::vector<Value>& values) {
  std::string text;
  for (const Value& value : values) text += (text.empty() ? "[" : ",") + ToJson(value);
  return text.empty() ? "[]" : text + "]";
}

// The JSON between the value of the field `last` and that of the field `path`: the ends of groups
// that `path` isn't in, the beginnings of its own, and its name. An empty `last` is the beginning
// of the record, an empty `path` its end.
std::string JsonBetween(std::string_view last, std::string_view path);

}  // namespace options_record_internal

// Every field of an options struct by its name, as JSON: groups as objects, enums as their names.
// Written as text, since the JSON library's trees can't be destroyed when memory has run out.
template <class Options>
std::string RecordFields(const Options& options) {
  std::string record;
  std::string last;
  VisitFields("", options, [&](const std::string& path, const auto&, const auto& value) {
    record += options_record_internal::JsonBetween(last, path);
    record += options_record_internal::ToJson(value);
    last = path;
  });
  return record + options_record_internal::JsonBetween(last, "");
}

// The options of a build from a record, for extending the map: those of features, keyframes,
// planes, panoramas' descriptions, orientation and layers, and of the pictures kept. All others,
// and those that the record doesn't name, have their defaults. Throws MapError(kMapDamaged) for a
// value that its option can't have.
BuildOptions OptionsOfRecord(const std::string& options_json);

// All options of a build except those on which the map doesn't depend, as stored in
// MapInfo::options_json.
std::string RecordOptions(const BuildOptions& options);

}  // namespace waystone
