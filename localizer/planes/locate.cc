// SPDX-License-Identifier: Apache-2.0
#include "localizer/planes/locate.h"

#include "core/base/check.h"
#include "core/base/clock.h"
#include "localizer/planes/decide.h"
#include "localizer/planes/explain.h"
#include "localizer/planes/shortlist.h"
#include "localizer/planes/verify.h"

namespace waystone {

Answer LocateByPlanes(const MapIndex& index, const Features& query,
                      const PlaneQueryOptions& options, const Deadline& deadline, bool explain) {
  WS_CHECK(query.type == index.map().info.feature_type, "features of another type than the map's");
  LapTimer timer;
  const std::vector<ShortlistedPlane> shortlist = ShortlistPlanes(index, query, options);
  const double shortlist_ms = timer.Lap();
  const std::vector<VerifiedPlane> tried = TryPlanes(index, query, shortlist, options, deadline);
  Answer answer = HasPassed(deadline)
                      ? Undecided(Stage::kShortlist)
                      : Decide(index, query, static_cast<int>(shortlist.size()), tried, options);
  if (deadline && !answer.last_stage) answer.last_stage = Stage::kDecide;
  answer.timing.shortlist_ms = shortlist_ms;
  answer.timing.verify_ms = timer.Lap();
  if (explain) answer.planes.explanation = Explain(index, query, shortlist, tried, options);
  answer.timing.total_ms = answer.timing.shortlist_ms + answer.timing.verify_ms;
  return answer;
}

}  // namespace waystone
