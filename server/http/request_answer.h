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
  size_t best = 0;  // the image whose answer counts: the one with the best of all, or of a series
                    // the last one
  bool series = false;         // whether the images were one
  bool used_previous = false;  // and began with the request's previous answer
  bool used_camera = false;    // whether anything of the map takes the photo's camera
  // What the next panorama is asked with as `previous.belief`; null without.
  Json belief;
};

using ServedMaps = std::vector<std::shared_ptr<const ServedMap>>;

// Asks every image of every map. Each image is a query of its own, but for panoramas asked of one
// map that has an appearance layer: several, or one with a previous answer's belief, are a series
// of one robot in their order. A previous answer of another version of the map isn't used. Throws
// MapError: kBadCamera for a camera that doesn't fit; kBadRequest for a belief that the map can't
// have given. Thread-safe.
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
//   belief      from the appearance layer: the likeliest nodes, for the next request's `previous`
//   stage       with deadline_ms: the last stage that was finished
//   camera      the camera that was understood
//   unused      what was understood and no layer of these maps uses
Json ToJson(const LocalizeRequest& request, const RequestAnswer& answer, bool across,
            const std::optional<Camera>& camera);

}  // namespace waystone
