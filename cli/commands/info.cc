// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "api/map_json.h"
#include "cli/commands/commands.h"
#include "cli/files/map_file.h"
#include "cli/output/build_text.h"
#include "cli/output/join_text.h"
#include "core/base/text.h"
#include "schema/file/map_store.h"
#include "schema/sessions.h"

namespace waystone {
namespace {

struct InfoFlags {
  std::string map;
  bool json = false;
};

Json InfoJson(const OpenMap& map, const std::vector<TableSize>& sizes, uint64_t bytes) {
  Json json = MapJson(map.name, *map.index);
  json["bytes"] = bytes;
  json["appearance"] = AppearanceJson(map.index->map());
  json["orientation"] = OrientationJson(map.index->map());
  json["tables"] = TablesJson(sizes);
  const std::string options = WithoutSessions(map.index->map().info.options_json);
  json["options"] = Json::parse(options, nullptr, false);
  if (json["options"].is_discarded()) json["options"] = nullptr;
  return json;
}

void PrintInfo(const OpenMap& map, const std::vector<TableSize>& sizes, uint64_t bytes) {
  const MapData& data = map.index->map();
  std::cout << map.name << ": " << CountsText(data) << ", " << BytesText(bytes) << '\n'
            << "  version   " << data.info.version << '\n'
            << "  built by  " << Printable(data.info.program) << " with "
            << NameOf(data.info.feature_type) << " features\n";
  for (const Sequence& sequence : data.sequences) {
    std::cout << "  sequence  " << Printable(sequence.name) << " (" << Printable(sequence.kind)
              << "): " << sequence.frames << " frames, " << sequence.skipped
              << " of them skipped\n";
  }
  for (const NamedPlace& place : data.names) {
    std::cout << "  place     " << Printable(place.name) << '\n';
  }
  for (const FloorPlanImage& plan : data.floor_plans) {
    std::cout << "  plan      " << Printable(plan.name) << " (" << SizeText(plan.width, plan.height)
              << " px)\n";
  }
  std::cout << HistoryText(data) << TablesText(sizes);
}

int RunInfo(const InfoFlags& flags) {
  const OpenMap map = OpenMapFile(flags.map, false);
  const std::vector<TableSize> sizes = TableSizes(flags.map);
  const uint64_t bytes = std::filesystem::file_size(flags.map);
  if (flags.json) {
    std::cout << Dump(InfoJson(map, sizes, bytes)) << '\n';
  } else {
    PrintInfo(map, sizes, bytes);
  }
  return 0;
}

}  // namespace

void AddInfo(CLI::App& app, Run& run) {
  auto flags = std::make_shared<InfoFlags>();
  CLI::App* command = app.add_subcommand("info", "Show the contents of a map");
  command->add_option("map", flags->map, "Map file")->required();
  command->add_flag("--json", flags->json, "Print one JSON object");
  command->footer("Example: waystone info lab.db");
  command->callback([flags, &run] { run = [flags] { return RunInfo(*flags); }; });
}

}  // namespace waystone
