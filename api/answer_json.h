// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "api/json.h"
#include "localizer/verdict/answer.h"
#include "localizer/verdict/answered_place.h"

namespace waystone {

// An answer of one map as the HTTP API and `waystone localize --json` print it: those fields of the
// schema Answer of clients/openapi.yaml that don't depend on the request (api/request_answer_json.h
// adds them), always in the same order. `place` is null unless localized. All functions are
// thread-safe.
Json ToJson(const Answer& answer);

// The schemas AnsweredPlace, and Place (an entry of a list).
Json ToJson(const AnsweredPlace& place);
Json ToJson(const PlaceCandidate& place);

}  // namespace waystone
