// SPDX-License-Identifier: Apache-2.0
#include "cli/files/keyframe_choice.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <sstream>
#include <vector>

#include "core/base/error.h"
#include "schema/sessions.h"

namespace waystone {
namespace {

std::optional<int64_t> WholeNumber(std::string_view text) {
  int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < 1) return std::nullopt;
  return value;
}

const MapSession& FindSession(const std::vector<MapSession>& sessions, const std::string& text) {
  std::vector<const MapSession*> named;
  for (const MapSession& session : sessions) {
    if (session.name == text) named.push_back(&session);
  }
  if (named.size() == 1) return *named.front();
  if (named.size() > 1) {
    throw MapError(ErrorCode::kNotFound, std::to_string(named.size()) + " sessions are named '" +
                                             text + "'; give the number of one");
  }
  const std::optional<int64_t> number = WholeNumber(text);
  if (number && *number <= std::ssize(sessions)) return sessions[static_cast<size_t>(*number - 1)];
  throw MapError(ErrorCode::kNotFound, "the map has no session '" + text + "'; it has " +
                                           std::to_string(sessions.size()) +
                                           ", which waystone info lists");
}

}  // namespace

std::set<KeyframeId> KeyframesOfSession(const MapData& map, const std::string& session) {
  const std::vector<MapSession> sessions = SessionsOf(map);
  const MapSession& chosen = FindSession(sessions, session);
  std::set<KeyframeId> ids;
  for (const Keyframe& keyframe : map.keyframes) {
    if (std::ranges::binary_search(chosen.sequences, keyframe.sequence)) ids.insert(keyframe.id);
  }
  return ids;
}

std::set<KeyframeId> KeyframesInRanges(const MapData& map, const std::string& ranges) {
  std::set<KeyframeId> ids;
  std::istringstream list(ranges);
  for (std::string range; std::getline(list, range, ',');) {
    const size_t dash = range.find('-');
    const auto first = WholeNumber(std::string_view(range).substr(0, dash));
    const auto last =
        dash == std::string::npos ? first : WholeNumber(std::string_view(range).substr(dash + 1));
    if (!first || !last || *last < *first) {
      throw MapError(ErrorCode::kUsage, "--keyframes " + ranges + ": '" + range +
                                            "' is no id and no range of ids; write 3,7,10-20");
    }
    const size_t before = ids.size();
    for (const Keyframe& keyframe : map.keyframes) {
      if (keyframe.id.value >= *first && keyframe.id.value <= *last) ids.insert(keyframe.id);
    }
    if (ids.size() > before) continue;
    throw MapError(ErrorCode::kNotFound, "the map has no keyframe of '" + range +
                                             "' that isn't named before; its ids are " +
                                             std::to_string(map.keyframes.front().id.value) +
                                             " to " +
                                             std::to_string(map.keyframes.back().id.value));
  }
  return ids;
}

}  // namespace waystone
