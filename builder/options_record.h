// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>

#include "core/base/options.h"

// The record of the options that a map was built with.
namespace waystone {

struct BuildOptions;

namespace options_record_internal {

template <class Value>
nlohmann::ordered_json ToRecord(const Value& value) {
  if constexpr (std::is_enum_v<Value>) {
    return std::string(NameOf(value));
  } else {
    return value;
  }
}

}  // namespace options_record_internal

// Every field of an options struct by its name: groups as objects, enums as their names.
template <class Options>
nlohmann::ordered_json RecordFields(const Options& options) {
  nlohmann::ordered_json record = nlohmann::ordered_json::object();
  VisitFields("", options, [&](const std::string& path, const auto&, const auto& value) {
    nlohmann::ordered_json* at = &record;
    size_t start = 0;
    for (size_t dot; (dot = path.find('.', start)) != std::string::npos; start = dot + 1) {
      at = &(*at)[path.substr(start, dot - start)];
    }
    (*at)[path.substr(start)] = options_record_internal::ToRecord(value);
  });
  return record;
}

// All options of a build but those that it doesn't depend on, as MapInfo::options_json holds them.
std::string RecordOptions(const BuildOptions& options);

}  // namespace waystone
