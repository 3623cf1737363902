// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/commands.h"
#include "cli/map_file.h"
#include "core/base/error.h"
#include "server/http/query_log.h"
#include "server/http/request_answer.h"

namespace waystone {
namespace {

struct ReplayFlags {
  std::string log;
  std::string map;
  bool json = false;
};

// What of an answer two maps can be compared by.
struct Outcome {
  std::string verdict;
  std::string place;  // the sequence and source of the keyframe or panorama; empty without one
  bool operator==(const Outcome&) const = default;
};

Outcome OutcomeOf(const Json& answer) {
  Outcome outcome{answer.value("verdict", ""), ""};
  const Json panorama = answer.value("panorama", Json::object());
  for (const Json& place : {answer.value("keyframe", Json()), panorama.value("node", Json())}) {
    if (!place.is_object()) continue;
    outcome.place = place.value("sequence", "") + "/" + place.value("source", "");
  }
  return outcome;
}

struct Replayed {
  std::string id;
  std::string image;
  Outcome before;
  Outcome after;
};

// What the next query of a series is asked with, by what the log's answer before it had.
using Beliefs = std::map<std::string, Json>;

std::string KeyOf(const Json& answer) {
  return answer.contains("belief") ? Dump(answer["belief"]) : "";
}

// A series goes on from what the map asked now made of its earlier panoramas, not from what the
// log's did: a belief names panoramas of one map. One whose beginning isn't in the log begins here.
void TakePrevious(const Beliefs& beliefs, LocalizeRequest& request) {
  const auto before =
      request.previous.is_null() ? beliefs.end() : beliefs.find(KeyOf(request.previous));
  request.previous = before == beliefs.end() ? Json(nullptr) : before->second;
}

// Nothing for a camera that the log's map stores and the one asked now doesn't.
std::optional<Camera> CameraIn(const MapData& map, const LocalizeRequest& request) {
  try {
    return CameraFor(request, map, request.images.front());
  } catch (const MapError& error) {
    if (error.code() != ErrorCode::kBadCamera) throw;
    return std::nullopt;
  }
}

Replayed Ask(LoggedQuery query, const ServedMaps& maps, Beliefs& beliefs) {
  // Time is the server's: what is compared is what the map makes of the image.
  query.request.deadline_ms.reset();
  TakePrevious(beliefs, query.request);
  LocalizeOptions options;
  options.camera = CameraIn(maps.front()->index().map(), query.request);
  const RequestAnswer answer = AnswerRequest(query.request, maps, options);
  const Json json = ToJson(query.request, answer, false, std::nullopt);
  const std::string key = KeyOf(query.answer);
  if (!key.empty()) beliefs[key] = {{"belief", answer.belief}};
  return {query.id, query.request.images.front().name, OutcomeOf(query.answer), OutcomeOf(json)};
}

Json ReplayJson(const std::vector<Replayed>& queries, size_t changed) {
  Json json = {{"queries", queries.size()}, {"changed", changed}, {"changes", Json::array()}};
  for (const Replayed& query : queries) {
    if (query.before == query.after) continue;
    json["changes"].push_back(
        {{"id", query.id},
         {"image", query.image},
         {"before", {{"verdict", query.before.verdict}, {"place", query.before.place}}},
         {"after", {{"verdict", query.after.verdict}, {"place", query.after.place}}}});
  }
  return json;
}

std::string TextOf(const Outcome& outcome) {
  return outcome.verdict + (outcome.place.empty() ? "" : " near " + outcome.place);
}

int RunReplay(const ReplayFlags& flags) {
  OpenMap map = OpenMapFile(flags.map, false);
  const ServedMaps maps = {std::make_shared<const ServedMap>(map.name, std::move(map.index))};
  std::vector<Replayed> queries;
  Beliefs beliefs;
  size_t changed = 0;
  for (LoggedQuery& query : ReadQueryLog(flags.log)) {
    queries.push_back(Ask(std::move(query), maps, beliefs));
    changed += queries.back().before != queries.back().after;
  }
  if (flags.json) {
    std::cout << Dump(ReplayJson(queries, changed)) << '\n';
    return 0;
  }
  for (const Replayed& query : queries) {
    if (query.before == query.after) continue;
    std::cout << query.id << " " << query.image << ": " << TextOf(query.before) << " -> "
              << TextOf(query.after) << '\n';
  }
  std::cout << changed << " of " << queries.size() << " answers changed\n";
  return 0;
}

}  // namespace

void AddReplay(CLI::App& app, Run& run) {
  auto flags = std::make_shared<ReplayFlags>();
  CLI::App* command = app.add_subcommand("replay", "Run logged queries again on another map");
  command->add_option("log", flags->log, "Folder written by waystone serve --query-log")
      ->required();
  command->add_option("map", flags->map, "Map file")->required();
  command->add_flag("--json", flags->json, "Print one JSON object");
  command->footer(
      "Lists the queries whose verdict or place changed. A series continues from the beliefs\n"
      "computed with the new map.\n"
      "Example: waystone replay queries/ lab-new.db");
  command->callback([flags, &run] { run = [flags] { return RunReplay(*flags); }; });
}

}  // namespace waystone
