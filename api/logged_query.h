// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "api/json.h"
#include "localizer/query.h"

// The log of `waystone serve --query-log`, which `waystone replay` reads: a folder with
// queries.jsonl, one object a query {id, time_s, map, request, images: [{name, file}], answer}, and
// the images' bytes, each once, in files named by their SHA-256.
namespace waystone {

constexpr const char* kQueryLogLines = "queries.jsonl";

// What of an answer two maps can be compared by.
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

// Throws MapError(kBadRequest) with the field that isn't of an answer's type.
QueryOutcome ReadOutcome(const Json& answer);

// One line of the log; `files` are the names of the images' files, in the images' order.
Json LoggedQueryJson(const LoggedQuery& query, double time_s,
                     const std::vector<std::string>& files);

// Gives all queries of a log in their order, with their images, at least one each: one at a time,
// as a log may be larger than the memory. Throws MapError, with the line and the field where it is
// theirs: kFileUnreadable, kBadRequest.
void ReadQueryLog(const std::filesystem::path& folder,
                  const std::function<void(LoggedQuery&)>& take);

}  // namespace waystone
