// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "localizer/localizer.h"
#include "server/http/localize_request.h"
#include "server/http/map_catalog.h"

namespace waystone {

// The answers of a request with one or more images, asked of one or more maps.
struct RequestAnswer {
  // For each image in its order the answers of the maps, best first: localized before ambiguous
  // before not in the map, more probable before less.
  std::vector<std::vector<Answer>> images;
  size_t best = 0;  // the image whose answer counts: the one with the best of all
};

using ServedMaps = std::vector<std::shared_ptr<const ServedMap>>;

// Asks every image of every map. Each image is a query of its own; no layer joins them yet.
// Throws MapError(kBadCamera) for a camera that doesn't fit. Thread-safe.
RequestAnswer AnswerRequest(const LocalizeRequest& request, const ServedMaps& maps,
                            const LocalizeOptions& options);

// What is answered when the deadline passes while the request waits for its turn.
RequestAnswer LateAnswer(const LocalizeRequest& request, const ServedMaps& maps);

// The best answer of all, as one map's answer and, when several maps recognised the place, with the
// verdict ambiguous and the maps' places.
Answer OverallAnswer(const RequestAnswer& answer);

// The whole as JSON: the overall answer's fields (answer_json.h), then where they say something
//   maps        across maps: each one's answer in short, ranked, at most top_k
//   images      of several images: each one's answer in short
//   candidates  with top_k: the places that were considered
//   stage       with deadline_ms: the last stage that was finished
//   camera      the camera that was understood
//   unused      what was understood and no layer of these maps uses
Json ToJson(const LocalizeRequest& request, const RequestAnswer& answer, bool across,
            const std::optional<Camera>& camera);

}  // namespace waystone
