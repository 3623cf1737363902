// SPDX-License-Identifier: Apache-2.0
#include "api/logged_query.h"

#include <fstream>
#include <iterator>

#include "api/query_request_json.h"
#include "core/base/error.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

std::string ReadWhole(const fs::path& path) {
  std::error_code ignored;
  std::ifstream in;
  if (fs::is_regular_file(path, ignored)) in.open(path, std::ios::binary);
  if (!in.is_open()) throw MapError(ErrorCode::kFileUnreadable, path.string() + " can't be read");
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

LoggedQuery ParseLine(const fs::path& folder, const std::string& line) {
  const Json json = ParseJson(line, kMaxAnswerDepth);
  LoggedQuery query;
  query.id = json.at("id").get<std::string>();
  query.map = json.at("map");
  query.answer = json.at("answer");
  if (!query.answer.is_object()) RefuseRequest("its answer is not an object");
  query.request = ParseQueryRequest(json.at("request"), {});
  for (const Json& image : json.at("images")) {
    // The name alone: a log from elsewhere must not read files beside it.
    const fs::path file = fs::path(image.at("file").get<std::string>()).filename();
    query.request.images.push_back({image.at("name").get<std::string>(), ReadWhole(folder / file)});
  }
  return query;
}

[[noreturn]] void RefuseLine(const fs::path& folder, int number, ErrorCode code,
                             const std::string& cause) {
  throw MapError(code, (folder / kQueryLogLines).string() + ", line " + std::to_string(number) +
                           " is not a logged query (" + cause + "); remove the line");
}

}  // namespace

Json LoggedQueryJson(const LoggedQuery& query, double time_s,
                     const std::vector<std::string>& files) {
  Json line = {{"id", query.id},
               {"time_s", time_s},
               {"map", query.map},
               {"request", ToJson(query.request)},
               {"images", Json::array()}};
  for (size_t i = 0; i < files.size(); ++i) {
    line["images"].push_back({{"name", query.request.images[i].name}, {"file", files[i]}});
  }
  line["answer"] = query.answer;
  return line;
}

std::vector<LoggedQuery> ReadQueryLog(const fs::path& folder) {
  std::ifstream in(folder / kQueryLogLines, std::ios::binary);
  if (!in) {
    throw MapError(ErrorCode::kFileUnreadable,
                   (folder / kQueryLogLines).string() +
                       " can't be read; expected a folder written by `waystone serve --query-log`");
  }
  std::vector<LoggedQuery> queries;
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    try {
      queries.push_back(ParseLine(folder, line));
    } catch (const Json::exception&) {
      RefuseLine(folder, number, ErrorCode::kBadRequest, "it lacks a field");
    } catch (const MapError& error) {
      RefuseLine(folder, number, error.code(), error.what());
    }
  }
  return queries;
}

}  // namespace waystone
