// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "api/json.h"
#include "builder/joining/merge_maps.h"
#include "builder/joining/prune_map.h"
#include "builder/joining/remove_keyframes.h"

// What maps that were joined look like to people, and to programs.
namespace waystone {

// What joining did, as lines and as JSON. `path` is the file of the joined map.
std::string JoinText(const std::string& path, const JoinResult& result);
Json JoinJson(const std::string& path, const JoinResult& result);

// The same of what was removed.
std::string RemovalText(const std::string& path, const RemoveResult& result);
Json RemovalJson(const std::string& path, const RemoveResult& result);

// The same of what was pruned.
std::string PruneText(const std::string& path, const PruneResult& result);
Json PruneJson(const std::string& path, const PruneResult& result);

// One line per session, and one per part where there are several: what `info` adds for a map with a
// history or of several parts. Empty for others.
std::string HistoryText(const MapData& map);

}  // namespace waystone
