// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "api/logged_query.h"
#include "api/query_request_json.h"
#include "tests/api/read_queries.h"
#include "tests/fuzz/fuzz_targets.h"

namespace waystone {
namespace {

// Writes a log as the server does.
void WriteLog(const std::vector<LoggedQuery>& queries) {
  std::filesystem::create_directories(FuzzFolder() / "written");
  std::string lines;
  int image = 0;
  for (const LoggedQuery& query : queries) {
    std::vector<std::string> files;
    for (const QueryImage& each : query.request.images) {
      files.push_back(std::to_string(image++) + ".jpg");
      WriteInput("written/" + files.back(), each.bytes);
    }
    lines += Dump(LoggedQueryJson(query, 0.5, files)) + "\n";
  }
  WriteInput(std::string("written/") + kQueryLogLines, lines);
}

bool SameImage(const QueryImage& a, const QueryImage& b) {
  return a.name == b.name && a.bytes == b.bytes;
}

bool SameQuery(const LoggedQuery& a, const LoggedQuery& b) {
  Json asked_a = ToJson(a.request);
  Json asked_b = ToJson(b.request);
  asked_a.erase("fov_deg");  // rounded
  asked_b.erase("fov_deg");
  return a.id == b.id && a.map == b.map && a.answer == b.answer && asked_a == asked_b &&
         std::ranges::equal(a.request.images, b.request.images, SameImage);
}

}  // namespace

// The input is queries.jsonl, beside an image a.jpg. A log is written and read to the same.
bool FuzzQueryLog(FuzzInput input) {
  std::filesystem::create_directories(FuzzFolder() / "read");
  WriteInput(std::string("read/") + kQueryLogLines, TextOf(input));
  WriteInput("read/a.jpg", "an image");
  const auto queries = ReadOrRefuse([] { return ReadQueries(FuzzFolder() / "read"); });
  if (!queries) return false;
  WriteLog(*queries);
  const auto again = ReadBack([] { return ReadQueries(FuzzFolder() / "written"); }, "a query log");
  Require(std::ranges::equal(*queries, again, SameQuery), "a log is written and read to the same");
  return true;
}

}  // namespace waystone
