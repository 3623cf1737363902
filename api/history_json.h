// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "api/json.h"
#include "schema/map_data.h"

// The sessions and parts of a map as JSON (schema/sessions). Both functions are thread-safe.
namespace waystone {

// Where the sequences came from: name, program and version of the map that became a session
// (version null for an added walk), its sequences, its number of keyframes, and the times of its
// first and last one (null without any). A map without a history is one session.
Json SessionsJson(const MapData& map);
// Which sequences are connected: a list of sequences for each part (FindParts).
Json PartsJson(const MapData& map);

}  // namespace waystone
