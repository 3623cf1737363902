// SPDX-License-Identifier: Apache-2.0
// Options that list their fields once. An options struct is a plain struct of tunables with a
// static function Fields(use), which passes one OptionField per member to `use`:
//
//   struct MatchOptions {
//     double max_ratio = 0.8;
//     bool mutual = true;
//
//     static constexpr auto Fields(const auto& use) {
//       return use(
//           OptionField{"max_ratio", &MatchOptions::max_ratio, OpenLow(0, 1), "",
//                       "Nearest over second nearest distance. Lower keeps fewer, surer matches."},
//           OptionField{"mutual", &MatchOptions::mutual, AnyValue(), "",
//                       "Keep only matches that are nearest both ways."});
//     }
//     void Check() const;  // throws MapError(kBadOptions)
//   };
//
// Range checks, the record in the map, overrides on the command line (--set) and docs/options.md
// follow from that list. A member that is itself such a struct is a group: its fields have its name
// before theirs, "planes.match.max_ratio". Fields() is a template, so a source that only includes
// the struct doesn't compile the list. All functions are thread-safe as long as no other thread
// changes the struct.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/base/error.h"

namespace waystone {

// The values that a number may have. NaN is in no range.
struct OptionRange {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_open = false;  // whether `low` itself is outside
  bool high_open = false;

  constexpr bool Contains(double value) const {
    return (low_open ? value > low : value >= low) && (high_open ? value < high : value <= high);
  }
};

constexpr OptionRange AnyValue() { return {}; }
constexpr OptionRange Closed(double low, double high) { return {low, high, false, false}; }
constexpr OptionRange Open(double low, double high) { return {low, high, true, true}; }
constexpr OptionRange OpenLow(double low, double high) { return {low, high, true, false}; }
constexpr OptionRange OpenHigh(double low, double high) { return {low, high, false, true}; }
constexpr OptionRange AtLeast(double low) { return {.low = low}; }
constexpr OptionRange Above(double low) { return {.low = low, .low_open = true}; }

// "between 0 and 1", "above 0", "at least 1 and below 5".
std::string ToText(const OptionRange& range);

// Who should change a field. kInternal is for values that were measured once for all data: nobody
// should have to touch them, and the documentation lists them separately.
enum class OptionUse { kTunable, kInternal };

template <class Options, class Value>
struct OptionField {
  std::string_view name;  // as the member's
  Value Options::*member;
  OptionRange range;
  std::string_view unit;  // "px", "rad", "s", ...; empty for none
  std::string_view help;  // one or two sentences: what it is, and what a change of it trades
  OptionUse use = OptionUse::kTunable;
};
template <class Options, class Value>
OptionField(std::string_view, Value Options::*, OptionRange, std::string_view, std::string_view)
    -> OptionField<Options, Value>;
template <class Options, class Value>
OptionField(std::string_view, Value Options::*, OptionRange, std::string_view, std::string_view,
            OptionUse) -> OptionField<Options, Value>;

// A member that is an options struct itself.
template <class Options, class Group>
struct OptionGroup {
  std::string_view name;
  Group Options::*member;
};
template <class Options, class Group>
OptionGroup(std::string_view, Group Options::*) -> OptionGroup<Options, Group>;

namespace options_internal {

template <class T>
struct IsGroup : std::false_type {};
template <class Options, class Group>
struct IsGroup<OptionGroup<Options, Group>> : std::true_type {};

inline std::string Joined(std::string_view path, std::string_view name) {
  return path.empty() ? std::string(name) : std::string(path) + "." + std::string(name);
}

[[noreturn]] void ThrowOutOfRange(const std::string& path, double value, const OptionRange& range,
                                  std::string_view unit);

}  // namespace options_internal

// Calls visit(path, field, value) for every field in the order of the lists, groups in place.
// `Options` may be const, and then the value is too. Compile-time recursion; allocates only the
// paths.
template <class Options, class Visit>
void VisitFields(std::string_view path, Options& options, Visit&& visit) {
  const auto one = [&](const auto& field) {
    const std::string full = options_internal::Joined(path, field.name);
    if constexpr (options_internal::IsGroup<std::decay_t<decltype(field)>>::value) {
      VisitFields(full, options.*(field.member), visit);
    } else {
      visit(full, field, options.*(field.member));
    }
  };
  std::remove_const_t<Options>::Fields([&](const auto&... fields) { (one(fields), ...); });
}

// Throws MapError(kBadOptions) for the first number that is out of its range, with the field's full
// name, its value and the range: "match.max_ratio is 1.5; it must be between 0 and 1".
template <class Options>
void CheckFields(std::string_view path, const Options& options) {
  VisitFields(path, options, [](const std::string& full, const auto& field, const auto& value) {
    using Value = std::decay_t<decltype(value)>;
    if constexpr (std::is_arithmetic_v<Value> && !std::is_same_v<Value, bool>) {
      const auto number = static_cast<double>(value);
      if (!field.range.Contains(number)) {
        options_internal::ThrowOutOfRange(full, number, field.range, field.unit);
      }
    }
  });
}

// `text` as a value of an option: a number, "true" or "false", any text, or numbers separated by
// commas. Throws MapError(kBadOptions) with the field's name for anything else. Enumerations
// declare an overload of their own.
void ParseOptionValue(const std::string& path, const std::string& text, bool* value);
void ParseOptionValue(const std::string& path, const std::string& text, int* value);
void ParseOptionValue(const std::string& path, const std::string& text, int64_t* value);
void ParseOptionValue(const std::string& path, const std::string& text, uint64_t* value);
void ParseOptionValue(const std::string& path, const std::string& text, float* value);
void ParseOptionValue(const std::string& path, const std::string& text, double* value);
void ParseOptionValue(const std::string& path, const std::string& text, std::string* value);
void ParseOptionValue(const std::string& path, const std::string& text, std::vector<double>* value);

// Sets the field of that full name. Returns whether there is one. Doesn't check the range: Check()
// does. Throws MapError(kBadOptions) for text that isn't a value of its type.
template <class Options>
bool SetField(std::string_view path, Options& options, const std::string& name,
              const std::string& text) {
  bool found = false;
  VisitFields(path, options, [&](const std::string& full, const auto&, auto& value) {
    if (full != name) return;
    ParseOptionValue(full, text, &value);
    found = true;
  });
  return found;
}

}  // namespace waystone
