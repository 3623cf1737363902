// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "api/json_value.h"
#include "core/base/ids.h"

// How our values become JSON. All functions are thread-safe.
namespace waystone {

// One line of text. Never throws: bytes of a name that are not UTF-8 become U+FFFD.
std::string Dump(const Json& json);

// `text` with U+FFFD for bytes that are not UTF-8.
std::string ToUtf8(const std::string& text);

// The number rounded to `decimals`, so that a value measured to a tenth isn't printed to 1e-16.
double Rounded(double value, int decimals);

Json ToJson(const Eigen::Matrix3d& matrix);                  // three rows of three, unrounded
Json ToJson(const std::vector<Eigen::Vector2d>& points_px);  // [[x, y], ...] to 1/100 px

template <class Tag>
Json ToJson(const std::vector<Id<Tag>>& ids) {
  Json list = Json::array();
  for (const Id<Tag>& id : ids) list.push_back(id.value);
  return list;
}

// null where there is no value.
template <class T>
Json OrNull(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

}  // namespace waystone
