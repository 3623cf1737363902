// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>
#include <cstdint>
#include <functional>

namespace waystone {

// A number that names one row of a map. Ids of different kinds are different types: a KeyframeId
// doesn't compile where a PlaneId is meant. Valid ids start at 1, as SQLite's do.
template <class Tag>
struct Id {
  int64_t value = 0;

  explicit operator bool() const { return value > 0; }
  auto operator<=>(const Id&) const = default;
};

using SequenceId = Id<struct SequenceTag>;
using KeyframeId = Id<struct KeyframeTag>;
using PlaneId = Id<struct PlaneTag>;
using AppearanceNodeId = Id<struct AppearanceNodeTag>;
using OrientationFrameId = Id<struct OrientationFrameTag>;

}  // namespace waystone

template <class Tag>
struct std::hash<waystone::Id<Tag>> {
  size_t operator()(waystone::Id<Tag> id) const { return std::hash<int64_t>()(id.value); }
};
