// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "api/json.h"
#include "cli/commands/commands.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "schema/file/map_store.h"

namespace waystone {
namespace {

struct CheckFlags {
  std::string map;
  bool json = false;
};

Json ProblemsJson(const std::string& map, const std::vector<MapProblem>& problems) {
  Json json;
  json["map"] = map;
  json["ok"] = problems.empty();
  json["problems"] = Json::array();
  for (const MapProblem& problem : problems) {
    json["problems"].push_back({{"where", problem.where}, {"message", problem.message}});
  }
  return json;
}

int RunCheck(const CheckFlags& flags) {
  const std::vector<MapProblem> problems = CheckMap(flags.map);
  if (flags.json) {
    std::cout << Dump(ProblemsJson(flags.map, problems)) << '\n';
  } else if (problems.empty()) {
    std::cout << flags.map << ": no damage found\n";
  } else {
    for (const MapProblem& problem : problems) {
      std::cout << Printable(problem.where + ": " + problem.message) << '\n';
    }
  }
  if (problems.empty()) return 0;
  std::cerr << "waystone: " << flags.map << " has " << problems.size()
            << (problems.size() == 1 ? " problem" : " problems")
            << "; rebuild the map or restore it from a backup\n";
  return InfoOf(ErrorCode::kMapDamaged).exit_code;
}

}  // namespace

void AddCheck(CLI::App& app, Run& run) {
  auto flags = std::make_shared<CheckFlags>();
  CLI::App* command = app.add_subcommand("check", "Check a map file for damage");
  command->add_option("map", flags->map, "Map file")->required();
  command->add_flag("--json", flags->json, "Print one JSON object");
  command->footer(
      "Lists all damage and exits with status 3 if there is any.\n"
      "Example: waystone check lab.db");
  command->callback([flags, &run] { run = [flags] { return RunCheck(*flags); }; });
}

}  // namespace waystone
