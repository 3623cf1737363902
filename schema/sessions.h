// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/ids.h"
#include "schema/map_data.h"

// The history of a map that was joined from others: which sequences came together, and from where.
namespace waystone {

// The sequences that one build put into a map.
struct MapSession {
  std::string name;                   // of the map that was joined, or of the walk that was added
  std::string program;                // "waystone 0.1.0": what built it
  std::string version;                // "sha256:..." of that map's file; empty for an added walk
  std::vector<SequenceId> sequences;  // ascending; some sequence of the map

  bool operator==(const MapSession&) const = default;
};

// The sessions of a map, each sequence in one of them. A map without a history is one session: its
// own. So is one whose history can't be read, or doesn't name each sequence once.
std::vector<MapSession> SessionsOf(const MapData& map);
// Whether the map has a history of its own.
bool HasHistory(const MapData& map);

// What a map holds of one session, and the times of the first and the last image among it; nothing
// where none has a time.
struct SessionContents {
  int keyframes = 0;
  int panoramas = 0;
  int orientation_frames = 0;
  std::optional<double> from_s;
  std::optional<double> to_s;

  bool operator==(const SessionContents&) const = default;
};

SessionContents ContentsOf(const MapData& map, const MapSession& session);

// The record of options with this history in place of the one that it had.
std::string WithSessions(const std::string& options_json, const std::vector<MapSession>& sessions);
// The record without a history: the options alone.
std::string WithoutSessions(const std::string& options_json);

// The parts of a map: sequences that have planes in common, planes that an edge joins, keyframes
// that a link joins, or nodes of the appearance or orientation layer that an edge joins, are of one
// part. From one part to another nothing leads. Ordered by their first sequence, sequences
// ascending. Sequences that are in no layer are parts of their own.
std::vector<std::vector<SequenceId>> FindParts(const MapData& map);

}  // namespace waystone
