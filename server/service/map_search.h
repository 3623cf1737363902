// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "localizer/options.h"
#include "localizer/session.h"
#include "server/service/map_source.h"
#include "server/service/query_gate.h"
#include "server/service/timed_queries.h"

namespace waystone {

// Of the maps that the coarse index proposes, at most this many are asked.
inline constexpr int kMaxSearched = 10;

// A map that was proposed, or one of all the maps, and what became of it.
struct SearchedMap {
  std::string name;
  std::string state;    // "asked", "late", "failed" or "too_large"
  double score = 0;     // of the coarse index: ranks the maps of one query, and says no more; 0
                        // without an index
  std::string message;  // one line: why it wasn't asked
};

// Maps that are asked together, and what became of each map that was to be asked.
struct FoundMaps {
  std::vector<QueriedMap> queried;
  std::vector<SearchedMap> searched;
};

// Opens all maps of a scope, which fit into memory together. Maps that were removed meanwhile are
// left out. Throws MapError with the code of the first one where none can be had. Thread-safe, as
// all here.
FoundMaps FindMaps(const SearchScope& scope, const MapSource::Deadline& deadline, MapSource& maps);

// Marks the maps that didn't answer by the deadline as late.
void TellLate(const RequestAnswer& answer, std::vector<SearchedMap>& searched);

// Whether one of these maps wasn't asked, so that the answer might be different.
bool IsPartial(const std::vector<SearchedMap>& searched);

struct SearchAnswer {
  RequestAnswer answer;
  std::optional<QueryCamera> camera;
  std::vector<SearchedMap> searched;  // as they were proposed: the likeliest first
  bool proposed = false;              // the index answered in time
  int unindexed = 0;                  // maps that can't be proposed

  // Whether the answer might be different if all proposed maps had been asked.
  bool IsPartial() const;
};

// Asks the maps of a scope that its coarse index proposes: the images are decoded and described
// once, the maps are opened in lots as memory allows, and each lot is asked like any maps. Holds a
// turn of the gate while it computes, and none while it waits for maps. Maps that aren't open by
// the deadline are late. Throws BusyError for a full gate, and MapError(kNotReady) where no map
// could be asked and there is no deadline.
SearchAnswer SearchMaps(const QueryRequest& request, const SearchScope& scope,
                        const LocalizeOptions& options, MapSource& maps, QueryGate& gate,
                        TimedQueries& computing);

}  // namespace waystone
