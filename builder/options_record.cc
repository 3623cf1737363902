// SPDX-License-Identifier: Apache-2.0
#include "builder/options_record.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "builder/build_options.h"
#include "core/base/error.h"

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

namespace {

using RecordJson = nlohmann::json;

// "planes.fusion.min_votes" in its groups; null where the record doesn't have it.
const RecordJson* FindInRecord(const RecordJson& record, const std::string& path) {
  const RecordJson* found = &record;
  for (size_t start = 0; start <= path.size();) {
    const size_t dot = std::min(path.find('.', start), path.size());
    if (!found->is_object()) return nullptr;
    const auto member = found->find(path.substr(start, dot - start));
    if (member == found->end()) return nullptr;
    found = &*member;
    start = dot + 1;
  }
  return found;
}

// As text for ParseOptionValue.
std::string RecordedText(const RecordJson& value) {
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_array()) return value.dump();
  std::string text;
  for (const RecordJson& entry : value) text += (text.empty() ? "" : ",") + RecordedText(entry);
  return text;
}

bool IsOfSources(const std::string& path) {
  return std::ranges::any_of(std::array{"features.", "keyframes.", "planes.",
                                        "appearance.describe.", "orientation.", "layers.", "image"},
                             [&](const char* start) { return path.starts_with(start); });
}

}  // namespace

BuildOptions OptionsOfRecord(const std::string& options_json) {
  // Deeper than any record of options: values are written again level by level.
  constexpr int kMaxDepth = 32;
  const auto is_shallow = [](int depth, RecordJson::parse_event_t, const RecordJson&) {
    return depth <= kMaxDepth;
  };
  const RecordJson record = RecordJson::parse(options_json, is_shallow, false);
  BuildOptions options;
  try {
    VisitFields("", options, [&](const std::string& path, const auto&, auto& value) {
      const RecordJson* recorded = IsOfSources(path) ? FindInRecord(record, path) : nullptr;
      if (recorded != nullptr) ParseOptionValue(path, RecordedText(*recorded), &value);
    });
    options.Check();
  } catch (const MapError& error) {
    throw MapError(ErrorCode::kMapDamaged,
                   std::string("the map's record of its options is wrong: ") + error.what());
  }
  return options;
}

std::string RecordOptions(const BuildOptions& options) { return RecordFields(options); }

}  // namespace waystone
