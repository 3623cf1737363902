// SPDX-License-Identifier: Apache-2.0
#include <fstream>
#include <iostream>
#include <memory>
#include <string>

#include "api/graph_formats.h"
#include "cli/commands.h"
#include "cli/map_file.h"
#include "core/base/error.h"
#include "schema/file/map_store.h"

namespace waystone {
namespace {

struct ExportFlags {
  std::string map;
  std::string format = "graphml";
  std::string output;
  bool force = false;
};

int RunExport(const ExportFlags& flags) {
  const OpenMap map = OpenMapFile(flags.map, false);
  const GraphText text = FormatGraph(*map.index, flags.format);
  if (flags.output.empty()) {
    std::cout << text.text << std::flush;
    return 0;
  }
  CheckWritable(flags.output, {flags.force});
  std::ofstream out(flags.output, std::ios::binary);
  if (!(out << text.text).flush()) {
    throw MapError(ErrorCode::kFileUnwritable,
                   flags.output + " can't be written; choose another place");
  }
  return 0;
}

}  // namespace

void AddExport(CLI::App& app, Run& run) {
  auto flags = std::make_shared<ExportFlags>();
  CLI::App* command = app.add_subcommand("export", "Write a map in a format of other programs");
  command->add_option("map", flags->map, "Map file")->required();
  command->add_option("--format", flags->format, "Format")
      ->capture_default_str()
      ->check(CLI::IsMember(GraphFormatNames()));
  command->add_option("-o,--output", flags->output, "File to write; stdout without it");
  command->add_flag("--force", flags->force, "Replace the file if it is there");
  command->footer(
      "graphml and dot hold planes and what is seen together; g2o, tum, ply, geojson and poses "
      "the\n"
      "poses of an appearance layer (maps of panoramas). What a map can't give is said with the "
      "reason.\n"
      "Example: waystone export lab.db --format graphml -o lab.graphml");
  command->callback([flags, &run] { run = [flags] { return RunExport(*flags); }; });
}

}  // namespace waystone
