// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "api/logged_query.h"
#include "api/query_request_json.h"
#include "api/request_answer_json.h"
#include "cli/commands/commands.h"
#include "cli/files/map_file.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "localizer/session.h"

namespace waystone {
namespace {

struct ReplayFlags {
  std::string log;
  std::string map;
  bool json = false;
};

struct Replayed {
  std::string id;
  std::string image;
  QueryOutcome before;
  QueryOutcome after;
};

// What the next query of a series is asked with, by what the log's answer before it had.
using Beliefs = std::map<std::string, PreviousAnswer>;

std::string KeyOf(const Json& belief) { return belief.is_null() ? "" : Dump(belief); }

// A series continues from what the map that is asked now made of its earlier panoramas, not from
// what the log's map did: a belief names panoramas of one map. A series whose beginning isn't in
// the log begins here.
void TakePrevious(const Beliefs& beliefs, QueryRequest& request) {
  if (!request.previous) return;
  const auto before = request.previous->belief
                          ? beliefs.find(KeyOf(ToJson(*request.previous->belief)))
                          : beliefs.end();
  request.previous.reset();
  if (before != beliefs.end()) request.previous = before->second;
}

// Removes what only the log's map has: keyframes, and a camera that the map asked now doesn't
// store.
void LeaveOutForeign(const MapData& map, QueryRequest& request) {
  request.prior_keyframe.reset();
  try {
    ResolveCamera(request, map, request.images.front());
  } catch (const MapError& error) {
    if (error.code() != ErrorCode::kBadCamera) throw;
    request.stored_camera.reset();
  }
}

Replayed Replay(LoggedQuery& query, const QueriedMap& map, Beliefs& beliefs) {
  // Deadlines are the server's: what is compared is what the map makes of the image.
  query.request.deadline_ms.reset();
  TakePrevious(beliefs, query.request);
  LeaveOutForeign(map.index->map(), query.request);
  const Session session(std::move(query.request), {map}, {});
  const RequestAnswer answer = session.Ask();
  const std::string key = KeyOf(query.answer.value("belief", Json()));
  if (!key.empty()) beliefs[key].belief = answer.belief.value_or(std::vector<NodeBelief>{});
  return {query.id, session.request().images.front().name, query.outcome,
          ReadOutcome(ToJson(session, answer, false))};
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

std::string TextOf(const QueryOutcome& outcome) {
  return outcome.verdict + (outcome.place.empty() ? "" : " near " + outcome.place);
}

int RunReplay(const ReplayFlags& flags) {
  const OpenMap opened = OpenMapFile(flags.map, false);
  const QueriedMap map{opened.name, opened.index};
  std::vector<Replayed> queries;
  Beliefs beliefs;
  size_t changed = 0;
  ReadQueryLog(flags.log, [&](LoggedQuery& query) {
    queries.push_back(Replay(query, map, beliefs));
    changed += queries.back().before != queries.back().after;
  });
  if (flags.json) {
    std::cout << Dump(ReplayJson(queries, changed)) << '\n';
    return 0;
  }
  for (const Replayed& query : queries) {
    if (query.before == query.after) continue;
    std::cout << Printable(query.id + " " + query.image + ": " + TextOf(query.before) + " -> " +
                           TextOf(query.after))
              << '\n';
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
