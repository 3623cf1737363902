// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "builder/joining/remove_keyframes.h"
#include "cli/commands/commands.h"
#include "cli/commands/settings.h"
#include "cli/files/chosen_ids.h"
#include "cli/files/map_file.h"
#include "cli/output/join_text.h"
#include "cli/system/signals.h"
#include "core/base/error.h"
#include "schema/file/map_lock.h"
#include "schema/file/map_store.h"

namespace waystone {
namespace {

struct RemoveFlags {
  std::string map;
  std::vector<std::string> sessions;
  std::vector<std::string> keyframes;
  std::vector<std::string> nodes;
  std::vector<std::string> regions;
  std::vector<std::string> places;
  std::vector<std::string> settings;  // of --set
  bool keep = false;
  bool json = false;
  bool quiet = false;
};

Removal ChooseRemoval(const MapData& map, const RemoveFlags& flags) {
  Removal removed{KeyframesOfIds(map, flags.keyframes), NodesOfIds(map, flags.nodes)};
  for (const std::string& session : flags.sessions) {
    removed.keyframes.merge(KeyframesOfSession(map, session));
    removed.nodes.merge(NodesOfSession(map, session));
    removed.sequences.merge(SequencesOfSession(map, session));
  }
  for (const std::string& text : flags.regions) {
    const NamedPolygon polygon = ReadPolygon("--region", text);
    removed.keyframes.merge(KeyframesInPolygon(map, polygon));
    removed.nodes.merge(NodesInPolygon(map, polygon));
  }
  for (const std::string& name : flags.places) {
    removed.keyframes.merge(KeyframesOfPlace(map, name));
    removed.nodes.merge(NodesOfPlace(map, name));
  }
  if (!removed.keyframes.empty() || !removed.nodes.empty() || !removed.sequences.empty()) {
    return removed;
  }
  throw MapError(
      ErrorCode::kUsage,
      "nothing to remove; give --session, --keyframes, --nodes, --place or --region with "
      "a keyframe or panorama in it (waystone info lists sessions)");
}

int RunRemove(const RemoveFlags& flags) {
  EndAtInterrupts();
  BuildOptions options;
  ApplySettings(flags.settings, options);
  options.Check();
  const MapLock lock(flags.map);
  MapData map = ReadMap(flags.map);
  CheckReplaceable(flags.map, flags.keep);
  const Removal removed = ChooseRemoval(map, flags);
  const RemoveResult result = RemoveFromMap(std::move(map), removed, options);
  NoteInterrupts();
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
  CLI::App* command = app.add_subcommand(
      "remove",
      "Remove sessions, keyframes or panoramas from a map; the original images are not needed");
  command->add_option("map", flags->map, "Map file, which is replaced")->required();
  command->add_option("--session", flags->sessions,
                      "Number or name of a session, as `waystone info` lists them; repeatable");
  command
      ->add_option("--keyframes", flags->keyframes,
                   "Ids of keyframes: 12, 120:180 or 3,5,9:12; repeatable")
      ->allow_extra_args(false);
  command
      ->add_option("--nodes", flags->nodes,
                   "Ids of panoramas (nodes of the appearance layer), likewise; repeatable")
      ->allow_extra_args(false);
  command->add_option("--place", flags->places,
                      "Named place whose keyframes and panoramas are removed; repeatable");
  command
      ->add_option(
          "--region", flags->regions,
          "Polygon on a map with poses or panoramas, as seen from above: \"0,0 4.5,0 4.5,3\". "
          "Keyframes and panoramas taken in it are removed; repeatable")
      ->allow_extra_args(false);
  command->add_flag("--keep", flags->keep, "Keep the previous version as MAP.previous");
  AddSetFlag(*command, flags->settings);
  command->add_flag("--json", flags->json, "Print the summary as one JSON object");
  command->add_flag("--quiet", flags->quiet, "Print errors only");
  command->footer("Example: waystone remove floor.db --session 2 --keep");
  command->callback([flags, &run] { run = [flags] { return RunRemove(*flags); }; });
}

}  // namespace waystone
