// SPDX-License-Identifier: Apache-2.0
#include "localizer/planes/locate.h"

#include <algorithm>

#include "core/base/check.h"
#include "core/base/clock.h"
#include "localizer/planes/decide.h"
#include "localizer/planes/explain.h"
#include "localizer/planes/shortlist.h"
#include "localizer/planes/sightings.h"
#include "localizer/planes/verify.h"

namespace waystone {

namespace {

// The inliers of the answered place: of its planes, and of the keyframes that were verified near
// the answered one.
std::vector<MapMatch> CollectMatches(const MapIndex& index, const Answer& answer,
                                     const std::vector<VerifiedPlane>& tried,
                                     const std::vector<VerifiedKeyframe>& keyframes) {
  std::vector<MapMatch> matches;
  for (const VerifiedPlane& plane : tried) {
    const PlaneId id = index.map().planes[plane.plane].id;
    if (std::ranges::count(answer.planes.recognised, id, &RecognisedPlane::id) == 0) continue;
    for (const Match& match : plane.inliers) {
      matches.push_back({match.a, index.FirstRow(plane.plane) + match.b});
    }
  }
  const int answered = index.IndexOf(answer.planes.keyframe->id);
  for (const VerifiedKeyframe& keyframe : keyframes) {
    if (!KeyframesAreNear(index, keyframe.keyframe, answered)) continue;
    matches.insert(matches.end(), keyframe.inliers.begin(), keyframe.inliers.end());
  }
  return matches;
}

}  // namespace

Answer LocateByPlanes(const MapIndex& index, const Features& query,
                      const PlaneQueryOptions& options, const Deadline& deadline, bool explain) {
  WS_CHECK(query.type == index.map().info.feature_type, "features of another type than the map's");
  LapTimer timer;
  const Shortlist shortlist = VoteForPlaces(index, query, options);
  const double shortlist_ms = timer.Lap();
  const std::vector<VerifiedPlane> tried =
      TryPlanes(index, query, shortlist.planes, options, deadline);
  const std::vector<VerifiedKeyframe> keyframes =
      VerifyKeyframes(index, query, shortlist, tried, options, deadline);
  Answer answer = HasPassed(deadline)
                      ? Undecided(Stage::kShortlist)
                      : Decide(index, query, static_cast<int>(shortlist.planes.size()), tried,
                               options, keyframes);
  if (deadline && !answer.last_stage) answer.last_stage = Stage::kDecide;
  answer.timing.shortlist_ms = shortlist_ms;
  answer.timing.verify_ms = timer.Lap();
  if (explain)
    answer.planes.explanation = Explain(index, query, shortlist, tried, keyframes, options);
  if (index.map().poses && answer.verdict == Verdict::kLocalized) {
    answer.planes.matches = CollectMatches(index, answer, tried, keyframes);
  }
  answer.timing.total_ms = answer.timing.shortlist_ms + answer.timing.verify_ms;
  return answer;
}

}  // namespace waystone
