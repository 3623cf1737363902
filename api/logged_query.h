// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "api/json.h"
#include "localizer/query.h"

// The log of `waystone serve --query-log`, which `waystone replay` reads: a folder with
// queries.jsonl, one object per query {id, time_s, map, request, images: [{name, file}], answer},
// and the images' bytes, each once, in files named by their SHA-256. All functions are thread-safe.
namespace waystone {

constexpr const char* kQueryLogLines = "queries.jsonl";

// The part of an answer by which two maps are compared.
struct QueryOutcome {
  std::string verdict;
  std::string place;  // the sequence and source of the keyframe or panorama; empty without one
  bool operator==(const QueryOutcome&) const = default;
};

struct LoggedQuery {
  std::string id;
  Json map;  // the map's name; null for a query across all maps
  QueryRequest request;
  Json answer;                // with `belief` null or a list
  QueryOutcome outcome = {};  // of the answer
};

// Throws MapError(kBadRequest) with the field that has the wrong type.
QueryOutcome ReadOutcome(const Json& answer);

// One line of the log; `files` are the names of the images' files, in the images' order.
Json LoggedQueryJson(const LoggedQuery& query, double time_s,
                     const std::vector<std::string>& files);

// Passes all queries of a log to `take` in their order, each with its images (at least one): one at
// a time, since a log may be larger than the memory. Throws MapError: kFileUnreadable, or
// kBadRequest with the line and the field at fault.
void ReadQueryLog(const std::filesystem::path& folder,
                  const std::function<void(LoggedQuery&)>& take);

}  // namespace waystone
