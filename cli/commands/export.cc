// SPDX-License-Identifier: Apache-2.0
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <string>

#include "api/graph_formats.h"
#include "cli/commands/commands.h"
#include "cli/files/map_file.h"
#include "core/base/error.h"
#include "schema/file/file_replacer.h"

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
  std::error_code ignored;
  if (std::filesystem::equivalent(flags.output, flags.map, ignored)) {
    throw MapError(ErrorCode::kFileExists,
                   flags.output + " is the map that is exported; choose another name");
  }
  FileReplacer file(flags.output, flags.force);
  std::ofstream out(file.temporary(), std::ios::binary);
  if (!(out << text.text).flush()) throw UnwritableError(flags.output, std::strerror(errno), 0);
  file.Commit();
  return 0;
}

}  // namespace

void AddExport(CLI::App& app, Run& run) {
  auto flags = std::make_shared<ExportFlags>();
  CLI::App* command = app.add_subcommand("export", "Export a map to other formats");
  command->add_option("map", flags->map, "Map file")->required();
  command->add_option("--format", flags->format, "Output format")
      ->capture_default_str()
      ->check(CLI::IsMember(GraphFormatNames()));
  command->add_option("-o,--output", flags->output, "Output file; default: stdout");
  command->add_flag("--force", flags->force, "Overwrite an existing file");
  command->footer(
      "graphml and dot contain the graph of planes; g2o, tum, ply, geojson and poses contain the\n"
      "poses of the appearance layer (maps of panoramas).\n"
      "Example: waystone export lab.db --format graphml -o lab.graphml");
  command->callback([flags, &run] { run = [flags] { return RunExport(*flags); }; });
}

}  // namespace waystone
