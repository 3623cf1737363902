// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/print_evidence.h"

#include <cstdio>

namespace waystone::bench {

void PrintEvidence(const char* kind, int query, const Answer& answer, bool right) {
  const auto& best = answer.planes.runner_up;
  std::printf("%s %d: %s %.3f %s%s\n", kind, query, NameOf(answer.verdict), answer.probability,
              answer.planes.keyframe ? answer.planes.keyframe->source.c_str()
              : best                 ? best->keyframe.source.c_str()
                                     : "-",
              answer.verdict == Verdict::kLocalized && !right ? " WRONG" : "");
  if (!answer.planes.explanation) return;
  for (const ExplainedPlace& place : answer.planes.explanation->places) {
    std::printf("  place at %lld: %d inliers, share %.2f, %.3f\n",
                static_cast<long long>(place.nearest.value), place.inliers, place.best_share,
                place.probability);
  }
  for (const ExplainedKeyframe& one : answer.planes.explanation->keyframes) {
    std::printf(
        "  keyframe %lld: %d of %d matches, %d independent, %d expected, coverage %.2f, "
        "place %d\n",
        static_cast<long long>(one.keyframe.value), one.inliers, one.matches, one.independent,
        one.expected, one.coverage, one.place);
  }
}

}  // namespace waystone::bench
