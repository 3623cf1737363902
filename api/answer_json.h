// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "api/json.h"
#include "localizer/verdict/answer.h"

namespace waystone {

// An answer as the HTTP API and `waystone localize --json` print it. Fields, always in this order:
//   verdict, probability, image, map, map_version, keyframe, heading, planes, panorama (only in
//   answers of the appearance layer: node, position, candidates, runner_up; the first two null when
//   not localized), places (only when ambiguous), runner_up, decided_by, message (only when not
//   localized), timing_ms, explanation (only when it was asked for).
// keyframe, heading and runner_up are null when there is none.
Json ToJson(const Answer& answer);

// A place in a list: keyframe, probability, inliers.
Json ToJson(const PlaceCandidate& place);

}  // namespace waystone
