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

[[noreturn]] void RefuseField(const std::string& field, const std::string& expected,
                              const Json& found) {
  RefuseRequest(field + " must be " + expected + ", not " + found.type_name());
}

// A field of an object that is itself at `path`; null where it is missing.
const Json& FieldOf(const Json& object, const std::string& path, const char* name) {
  static const Json kMissing;
  if (!object.is_object()) RefuseField(path, "an object", object);
  const auto found = object.find(name);
  return found == object.end() ? kMissing : *found;
}

std::string TextIn(const Json& object, const std::string& path, const char* name) {
  const Json& value = FieldOf(object, path, name);
  if (!value.is_string()) RefuseField(path + "'s " + name, "a string", value);
  return value.get<std::string>();
}

// The place that an answer names, if any.
void ReadPlace(const Json& place, const std::string& path, QueryOutcome& outcome) {
  if (place.is_null()) return;
  outcome.place = TextIn(place, path, "sequence") + "/" + TextIn(place, path, "source");
}

std::vector<QueryImage> ReadImages(const fs::path& folder, const Json& images) {
  if (!images.is_array()) RefuseField("the line's images", "a list", images);
  if (images.empty()) RefuseRequest("the line's images are none; expected one at least");
  std::vector<QueryImage> read;
  for (const Json& image : images) {
    const std::string path = "images[" + std::to_string(read.size()) + "]";
    // Only the file name: a log from elsewhere must not name files outside its folder.
    const fs::path file = fs::path(TextIn(image, path, "file")).filename();
    read.push_back({TextIn(image, path, "name"), ReadWhole(folder / file)});
  }
  return read;
}

LoggedQuery ParseLine(const fs::path& folder, const std::string& line) {
  const Json json = ParseJson(line, kAnswerBounds);
  const auto field = [&json](const char* name) -> const Json& {
    return FieldOf(json, "the line", name);
  };
  LoggedQuery query;
  query.id = TextIn(json, "the line", "id");
  query.map = field("map");
  if (!query.map.is_string() && !query.map.is_null())
    RefuseField("the line's map", "a string or null", query.map);
  query.answer = field("answer");
  query.outcome = ReadOutcome(query.answer);
  query.request = ParseQueryRequest(field("request"), {});
  query.request.images = ReadImages(folder, field("images"));
  CheckOdometry(query.request);
  return query;
}

[[noreturn]] void RefuseLine(const fs::path& folder, int number, ErrorCode code,
                             const std::string& cause) {
  throw MapError(code, (folder / kQueryLogLines).string() + ", line " + std::to_string(number) +
                           " is not a logged query (" + cause + "); remove the line");
}

LoggedQuery ReadLine(const fs::path& folder, const std::string& line, int number) {
  try {
    return ParseLine(folder, line);
  } catch (const MapError& error) {
    RefuseLine(folder, number, error.code(), error.what());
  }
}

}  // namespace

QueryOutcome ReadOutcome(const Json& answer) {
  QueryOutcome outcome{TextIn(answer, "the answer", "verdict"), ""};
  ReadPlace(FieldOf(answer, "the answer", "keyframe"), "the answer's keyframe", outcome);
  if (const Json& panorama = FieldOf(answer, "the answer", "panorama"); !panorama.is_null()) {
    ReadPlace(FieldOf(panorama, "the answer's panorama", "node"), "the panorama's node", outcome);
  }
  const Json& belief = FieldOf(answer, "the answer", "belief");
  if (!belief.is_null() && !belief.is_array()) RefuseField("the answer's belief", "a list", belief);
  return outcome;
}

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

void ReadQueryLog(const fs::path& folder, const std::function<void(LoggedQuery&)>& take) {
  std::ifstream in(folder / kQueryLogLines, std::ios::binary);
  if (!in) {
    throw MapError(ErrorCode::kFileUnreadable,
                   (folder / kQueryLogLines).string() +
                       " can't be read; expected a folder written by `waystone serve --query-log`");
  }
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    LoggedQuery query = ReadLine(folder, line, number);
    take(query);
  }
}

}  // namespace waystone
