// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "api/json.h"
#include "localizer/verdict/answer.h"
#include "localizer/verdict/answered_place.h"

namespace waystone {

// An answer as the HTTP API and `waystone localize --json` print it. Fields, always in this order:
//   verdict, probability, image, map, map_version, place, keyframe, heading, planes, panorama (only
//   in answers of the appearance layer: node, position, candidates, runner_up; the first two null
//   when not localized), places (only when ambiguous), runner_up, decided_by, message (only when
//   not localized), timing_ms, explanation (only when it was asked for).
// place is null unless localized; keyframe, heading and runner_up are null when there is none.
Json ToJson(const Answer& answer);

// layer, id, image, sequence, time_s, position, heading; the last three null where not known.
Json ToJson(const AnsweredPlace& place);

// A place in a list: keyframe, probability, inliers.
Json ToJson(const PlaceCandidate& place);

}  // namespace waystone
