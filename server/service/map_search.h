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

// A map that was proposed, and what became of it.
struct SearchedMap {
  std::string name;
  std::string state;    // "asked", "late", "failed" or "too_large"
  double score = 0;     // of the coarse index, which ranks the maps of one query and says no more
  std::string message;  // one line: why it wasn't asked
};

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
