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

// At most so many maps are asked of those that the coarse index proposes.
inline constexpr int kMaxSearched = 10;

// A map that was proposed, or is one of all, and what became of it.
struct SearchedMap {
  std::string name;
  std::string state;    // "asked", "late", "failed" or "too_large"
  double score = 0;     // of the coarse index, which ranks the maps of one query and says no more;
                        // 0 without
  std::string message;  // one line: why it wasn't asked
};

// Maps that are asked together, and what became of each one that was to be.
struct FoundMaps {
  std::vector<QueriedMap> queried;
  std::vector<SearchedMap> searched;
};

// Opens all maps of a scope, which fit into memory together. Those that were removed meanwhile are
// left out. Throws where none can be had, with the first one's code.
FoundMaps FindMaps(const SearchScope& scope, const MapSource::Deadline& deadline, MapSource& maps);

// Says of maps that didn't answer by the deadline that they were late.
void TellLate(const RequestAnswer& answer, std::vector<SearchedMap>& searched);

// Whether a map of these wasn't asked, so that the answer might be another one.
bool IsPartial(const std::vector<SearchedMap>& searched);

struct SearchAnswer {
  RequestAnswer answer;
  std::optional<QueryCamera> camera;
  std::vector<SearchedMap> searched;  // as they were proposed: the likeliest first
  bool proposed = false;              // in time
  int unindexed = 0;                  // maps that can't be proposed

  // Whether the answer might be another one if all maps that were proposed had been asked.
  bool IsPartial() const;
};

// Asks the maps of a scope that its coarse index proposes: the images are decoded and described
// once, the maps are opened lot by lot as memory allows, and each lot is asked as any maps are.
// Holds a turn of the gate while it computes, and none while it waits for maps. What isn't open by
// the deadline is late. Throws BusyError for a full gate, and MapError(kNotReady) where no map
// could be asked and there is no deadline.
SearchAnswer SearchMaps(const QueryRequest& request, const SearchScope& scope,
                        const LocalizeOptions& options, MapSource& maps, QueryGate& gate,
                        TimedQueries& computing);

}  // namespace waystone
