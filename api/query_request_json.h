// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <string_view>
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

  static constexpr auto Fields(const auto& use) {
    return use(OptionField{"max_images", &RequestLimits::max_images, Closed(1, 64), "",
                           "Images of one request: a rig's, or a series. Each costs a query."},
               OptionField{"max_deadline_ms", &RequestLimits::max_deadline_ms, AtLeast(1), "ms",
                           "Longest deadline that a client may set."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// A request from its object; the images' bytes are the caller's, `with_images` says whether the
// field `images` is known.
QueryRequest ParseQueryRequest(const Json& object, const RequestLimits& limits,
                               bool with_images = false);

// Refuses motions that are not one for each image.
void CheckOdometry(const QueryRequest& request);

// The object of a request, without images: ParseQueryRequest reads it again.
Json ToJson(const QueryRequest& request);

// [{"node", "probability", "heading_rad", "deviation_rad"}, ...]
Json ToJson(const std::vector<NodeBelief>& belief);

// ---- for readers of bodies

[[noreturn]] void RefuseRequest(const std::string& cause);
// In quotes, without control characters.
std::string QuoteShortened(const std::string& text);

// Of what is parsed: copying a value takes stack for each level, and each of the values takes some
// 60 bytes where its text may take two.
struct JsonBounds {
  int depth = 0;
  int values = 0;
};
// Beyond any request, and beyond any answer.
constexpr JsonBounds kRequestBounds{8, 20'000};
constexpr JsonBounds kAnswerBounds{32, 1'000'000};
// Of one object and of a field's name, whatever is parsed: the parser compares each name with all
// before it. No object of ours comes near.
constexpr size_t kMaxFields = 64;
constexpr size_t kMaxFieldBytes = 200;

// Refuses what is over the bounds, and objects that have a field twice.
Json ParseJson(std::string_view text, const JsonBounds& bounds = kRequestBounds);

// A text of at most kMaxNameBytes.
std::string NameIn(const Json& value, const std::string& field);

// Refuses what isn't an object or has a field that isn't known.
void CheckKnownFields(const Json& object, const std::string& what,
                      const std::set<std::string>& known);

}  // namespace waystone
