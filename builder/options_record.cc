// SPDX-License-Identifier: Apache-2.0
#include "builder/options_record.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "builder/build_options.h"

namespace waystone {
namespace options_record_internal {

std::string ToJson(bool value) { return value ? "true" : "false"; }
std::string ToJson(double value) { return nlohmann::json(value).dump(); }
std::string ToJson(std::string_view value) { return nlohmann::json(value).dump(); }

std::string JsonBetween(std::string_view last, std::string_view path) {
  // Where both are in the same groups.
  const auto parts = std::ranges::mismatch(last, path);
  const size_t same = static_cast<size_t>(parts.in1 - last.begin());
  const size_t common = last.substr(0, same).rfind('.') + 1;
  const std::string_view closed = last.substr(common);
  std::string text(static_cast<size_t>(std::ranges::count(closed, '.')), '}');
  if (path.empty()) return text + "}";
  text += last.empty() ? "{" : ",";
  for (size_t start = common; start < path.size();) {
    const size_t dot = std::min(path.find('.', start), path.size());
    text += '"' + std::string(path.substr(start, dot - start)) + "\":";
    if (dot < path.size()) text += '{';
    start = dot + 1;
  }
  return text;
}

}  // namespace options_record_internal

std::string RecordOptions(const BuildOptions& options) { return RecordFields(options); }

}  // namespace waystone
