// SPDX-License-Identifier: Apache-2.0
#include "bench/baseline/scenes.h"

#include "core/base/check.h"

namespace waystone::bench {

SceneAnswer SceneAnswerOf(const MapIndex& index, const Answer& answer) {
  WS_CHECK(answer.verdict == Verdict::kLocalized, "only a localized answer names a place");
  const RecognisedPlane& best = answer.planes.recognised.front();
  return {index.FindKeyframe(answer.planes.keyframe->id)->frame,
          index.FindKeyframe(best.reference.id)->frame, best.reference_from_query,
          best.query_points};
}

}  // namespace waystone::bench
