// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "api/json.h"
#include "schema/map_data.h"

// The sessions and parts of a map as JSON (schema/sessions).
namespace waystone {

// Where the sequences came from: name, program and version of the map that a session was (version
// null for an added walk), its sequences, how many keyframes it has and the times of the first and
// the last of them (null without any). A map without a history is one session.
Json SessionsJson(const MapData& map);
// Which sequences hang together: a list of sequences for each part (FindParts).
Json PartsJson(const MapData& map);

}  // namespace waystone
