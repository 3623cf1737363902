// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/ids.h"
#include "schema/map_data.h"

// The history of a map that was joined from others: which sequences came together, and from where.
// All functions are pure; thread-safe.
namespace waystone {

// The sequences that one build put into a map.
struct MapSession {
  std::string name;                   // of the map that was joined, or of the walk that was added
  std::string program;                // "waystone 0.1.0": what built it
  std::string version;                // "sha256:..." of that map's file; empty for an added walk
  std::vector<SequenceId> sequences;  // ascending; some sequence of the map

  bool operator==(const MapSession&) const = default;
};

// The sessions of a map, each sequence in one of them. A map without a history has one session:
// itself. So does one whose history can't be read or doesn't name each sequence once.
std::vector<MapSession> SessionsOf(const MapData& map);
// Whether the map has a history of its own.
bool HasHistory(const MapData& map);

// The contents of one session of a map, and the times of its first and last image; nothing where
// none has a time.
struct SessionContents {
  int keyframes = 0;
  int panoramas = 0;
  int orientation_frames = 0;
  std::optional<double> from_s;
  std::optional<double> to_s;

  bool operator==(const SessionContents&) const = default;
};

SessionContents ContentsOf(const MapData& map, const MapSession& session);

// The record of options with its history replaced by this one.
std::string WithSessions(const std::string& options_json, const std::vector<MapSession>& sessions);
// The record without a history: only the options.
std::string WithoutSessions(const std::string& options_json);

// The connected parts of a map: sequences belong to one part if they have planes in common, planes
// that an edge joins, keyframes that a link joins, or nodes of the appearance or orientation layer
// that an edge joins. Ordered by their first sequence, sequences ascending. Sequences that are in
// no layer are parts of their own.
std::vector<std::vector<SequenceId>> FindParts(const MapData& map);

}  // namespace waystone
