// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "builder/joining/joinable.h"
#include "builder/joining/remove_keyframes.h"
#include "cli/commands/commands.h"
#include "cli/commands/settings.h"
#include "cli/files/chosen_ids.h"
#include "cli/files/map_file.h"
#include "cli/output/join_text.h"
#include "core/base/error.h"
#include "schema/file/map_store.h"

namespace waystone {
namespace {

struct RemoveFlags {
  std::string map;
  std::vector<std::string> sessions;
  std::vector<std::string> keyframes;
  std::vector<std::string> regions;
  std::vector<std::string> places;
  std::vector<std::string> settings;  // of --set
  bool keep = false;
  bool json = false;
  bool quiet = false;
};

int RunRemove(const RemoveFlags& flags) {
  BuildOptions options;
  ApplySettings(flags.settings, options);
  options.Check();
  MapData map = ReadMap(flags.map);
  CheckLayersAreJoinable(map);
  std::set<KeyframeId> removed = KeyframesOfIds(map, flags.keyframes);
  for (const std::string& session : flags.sessions) {
    removed.merge(KeyframesOfSession(map, session));
  }
  for (const std::string& text : flags.regions) {
    removed.merge(KeyframesInPolygon(map, ReadPolygon("--region", text)));
  }
  for (const std::string& name : flags.places) removed.merge(KeyframesOfPlace(map, name));
  if (removed.empty()) {
    throw MapError(ErrorCode::kUsage,
                   "nothing to remove; give --session, --keyframes, --place or --region with a "
                   "keyframe in it (waystone info lists sessions)");
  }
  const RemoveResult result = RemoveKeyframes(std::move(map), removed, options);
  ReplaceMap(result.map, flags.map, flags.keep);
  if (flags.json) {
    std::cout << Dump(RemovalJson(flags.map, result)) << '\n';
  } else if (!flags.quiet) {
    std::cout << RemovalText(flags.map, result);
  }
  return 0;
}

}  // namespace

void AddRemove(CLI::App& app, Run& run) {
  auto flags = std::make_shared<RemoveFlags>();
  CLI::App* command =
      app.add_subcommand("remove", "Remove sessions or keyframes from a map, without its sources");
  command->add_option("map", flags->map, "Map file, which is replaced")->required();
  command->add_option("--session", flags->sessions,
                      "Number or name of a session, as `waystone info` lists them; repeatable");
  command
      ->add_option("--keyframes", flags->keyframes,
                   "Ids of keyframes: 12, 120:180 or 3,5,9:12; repeatable")
      ->allow_extra_args(false);
  command->add_option("--place", flags->places,
                      "Named place whose keyframes are removed; repeatable");
  command
      ->add_option(
          "--region", flags->regions,
          "Polygon on a map with poses, as seen from above: \"0,0 4.5,0 4.5,3\". Keyframes "
          "taken in it are removed; repeatable")
      ->allow_extra_args(false);
  command->add_flag("--keep", flags->keep, "Keep the previous version as MAP.previous");
  AddSetFlag(*command, flags->settings);
  command->add_flag("--json", flags->json, "Print the summary as one JSON object");
  command->add_flag("--quiet", flags->quiet, "Print errors only");
  command->footer("Example: waystone remove floor.db --session 2 --keep");
  command->callback([flags, &run] { run = [flags] { return RunRemove(*flags); }; });
}

}  // namespace waystone
