// SPDX-License-Identifier: Apache-2.0
// Checks that an options struct lists all of its members in Fields(): a member that isn't listed is
// neither checked, recorded nor documented. Pure; thread-safe.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "core/base/options.h"

namespace waystone {
namespace options_internal {

// Converts to any type in unevaluated contexts.
struct AnyMember {
  template <class Value>
  operator Value() const;  // NOLINT(google-explicit-constructor)
};

template <class Struct, size_t... i>
constexpr bool TakesMembers(std::index_sequence<i...>) {
  return requires { Struct{(static_cast<void>(i), AnyMember{})...}; };
}

template <class Struct, size_t n = 1>
constexpr size_t CountMembers() {
  if constexpr (TakesMembers<Struct>(std::make_index_sequence<n>())) {
    return CountMembers<Struct, n + 1>();
  } else {
    return n - 1;
  }
}

template <class Options>
constexpr size_t CountUnlisted() {
  if constexpr (requires { Options::kUnlistedMembers; }) return Options::kUnlistedMembers;
  return 0;
}

}  // namespace options_internal

// Which of the structs of options, `Options` itself and the groups in it, have members that their
// Fields() don't name: "planes.fusion lists 12 of its 13 members", one line per struct; empty when
// all are complete. The structs must be aggregates without arrays and base classes. A struct with
// members that aren't options (a callback, facts about one query) says how many:
// `static constexpr int kUnlistedMembers = 2;`.
template <class Options>
std::string FindUnlistedMembers(const std::string& path) {
  constexpr size_t members =
      options_internal::CountMembers<Options>() - options_internal::CountUnlisted<Options>();
  constexpr size_t listed = Options::Fields([](const auto&... entry) { return sizeof...(entry); });
  std::string found;
  if (listed != members) {
    found = path + " lists " + std::to_string(listed) + " of its " + std::to_string(members) +
            " members\n";
  }
  const auto look = [&]<class Entry>(const Entry& entry) {
    if constexpr (options_internal::IsGroup<Entry>::value) {
      using Group = std::decay_t<decltype(std::declval<Options>().*(entry.member))>;
      found += FindUnlistedMembers<Group>(options_internal::Joined(path, entry.name));
    }
  };
  Options::Fields([&](const auto&... entry) { (look(entry), ...); });
  return found;
}

}  // namespace waystone
