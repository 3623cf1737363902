// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "api/json.h"
#include "core/base/options.h"
#include "localizer/query.h"

// Client requests as JSON: the object in a body or in a form's part `request`, in logs, and from
// `waystone localize --server`. All functions that read throw MapError(kBadRequest) with the field
// at fault for values that are unknown, out of range or contradictory. All functions are
// thread-safe.
namespace waystone {

// Longest image name, in bytes, since answers repeat it.
constexpr size_t kMaxNameBytes = 200;

struct RequestLimits {
  int max_images = 8;
  int max_deadline_ms = 60'000;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{
            "max_images", &RequestLimits::max_images, Closed(1, 64), "",
            "Maximum number of images in a request (of a rig, or a series). Each costs a query."},
        OptionField{"max_deadline_ms", &RequestLimits::max_deadline_ms, AtLeast(1), "ms",
                    "Maximum deadline that a client may set."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// A request from its object; the caller adds the images' bytes, and `with_images` says whether the
// field `images` is allowed.
QueryRequest ParseQueryRequest(const Json& object, const RequestLimits& limits,
                               bool with_images = false);

// Refuses odometry that doesn't have one motion per image.
void CheckOdometry(const QueryRequest& request);

// The object of a request, without images, which ParseQueryRequest can read.
Json ToJson(const QueryRequest& request);

// [{"node", "probability", "heading_rad", "deviation_rad"}, ...]
Json ToJson(const std::vector<NodeBelief>& belief);

// ---- for readers of bodies

[[noreturn]] void RefuseRequest(const std::string& cause);
// In quotes, without control characters.
std::string QuoteShortened(const std::string& text);

// Limits for parsed JSON: copying a value takes stack for each level, and each value takes some 60
// bytes, although its text may take two.
struct JsonBounds {
  int depth = 0;
  int values = 0;
};
// Larger than any request, and than any answer.
constexpr JsonBounds kRequestBounds{8, 20'000};
constexpr JsonBounds kAnswerBounds{32, 1'000'000};
// Limits for the fields of any object and for their names: the parser compares each name with all
// before it. Our objects are far smaller.
constexpr size_t kMaxFields = 64;
constexpr size_t kMaxFieldBytes = 200;

// Refuses text that exceeds the bounds, and objects with a duplicate field.
Json ParseJson(std::string_view text, const JsonBounds& bounds = kRequestBounds);

// An integer that may be written with a fraction of zero, as 2.0: JSON Schema doesn't distinguish
// these. Nothing for any other value, and beyond 64 bits.
std::optional<int64_t> WholeNumber(const Json& value);

// A text of at most kMaxNameBytes.
std::string NameIn(const Json& value, const std::string& field);

// Refuses a value that isn't an object or has an unknown field.
void CheckKnownFields(const Json& object, const std::string& what,
                      const std::set<std::string>& known);

}  // namespace waystone
