// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "api/json.h"
#include "core/base/options.h"
#include "localizer/query.h"

// What clients ask as JSON: the object that a body or a form's part `request` holds, logs keep and
// `waystone localize --server` sends. Every function that reads throws MapError(kBadRequest) with
// the field at fault for what is unknown, out of range or contradicts itself.
namespace waystone {

// Longest name of an image that an answer repeats.
constexpr size_t kMaxNameBytes = 200;

struct RequestLimits {
  int max_images = 8;
  int max_deadline_ms = 60'000;

  static constexpr auto Fields() {
    return std::tuple{
        OptionField{"max_images", &RequestLimits::max_images, Closed(1, 64), "",
                    "Images of one request: a rig's, or a series. Each costs a query."},
        OptionField{"max_deadline_ms", &RequestLimits::max_deadline_ms, AtLeast(1), "ms",
                    "Longest deadline that a client may set."}};
  }
  void Check() const { CheckFields("limits", *this); }  // throws MapError(kBadOptions)
};

// A request from its object; the images' bytes are the caller's, `with_images` says whether the
// field `images` is known.
QueryRequest ParseQueryRequest(const Json& object, const RequestLimits& limits,
                               bool with_images = false);

// The object of a request, without images: ParseQueryRequest reads it again.
Json ToJson(const QueryRequest& request);

// [{"node", "probability", "heading_rad", "deviation_rad"}, ...]
Json ToJson(const std::vector<NodeBelief>& belief);

// ---- for readers of bodies

[[noreturn]] void RefuseRequest(const std::string& cause);
// In quotes, without control characters.
std::string QuoteShortened(const std::string& text);

// Deeper than any request, and than any answer.
constexpr int kMaxRequestDepth = 8;
constexpr int kMaxAnswerDepth = 32;

// JSON of a bounded depth: copying it takes stack for each level.
Json ParseJson(std::string_view text, int max_depth = kMaxRequestDepth);

// A text of at most kMaxNameBytes.
std::string NameIn(const Json& value, const std::string& field);

// Refuses what isn't an object or has a field that isn't known.
void CheckKnownFields(const Json& object, const std::string& what,
                      const std::set<std::string>& known);

}  // namespace waystone
