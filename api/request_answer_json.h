// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "api/json.h"
#include "localizer/session.h"

namespace waystone {

// The answer to a whole request, to several maps (`across`) or one: the overall answer's fields
// (answer_json.h), then, where they apply
//   maps        across maps: each one's answer in short, ranked, at most top_k
//   images      of several images: each one's answer in short
//   candidates  with top_k: the places that were considered
//   belief      from the appearance layer: the likeliest nodes, for the next request's `previous`
//   stage       with deadline_ms: the last stage that was finished
//   camera      the camera that was understood
//   unused      what was understood and no layer of these maps uses
Json ToJson(const Session& session, const RequestAnswer& answer, bool across);
// The same without a session. Both are thread-safe.
Json ToJson(const QueryRequest& request, const std::optional<QueryCamera>& camera,
            const RequestAnswer& answer, bool across);

}  // namespace waystone
