// SPDX-License-Identifier: Apache-2.0
#include "builder/build_map.h"

#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/query_request_json.h"
#include "builder/report/report.h"
#include "cli/commands/build_flags.h"
#include "cli/commands/build_sources.h"
#include "cli/commands/commands.h"
#include "cli/files/kept_names.h"
#include "cli/files/kept_plans.h"
#include "cli/files/map_file.h"
#include "cli/files/output_file.h"
#include "cli/output/build_text.h"
#include "cli/system/signals.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "schema/file/map_lock.h"
#include "schema/file/map_store.h"

namespace waystone {
namespace {

struct MapBuildFlags {
  BuildFlags build;
  std::string output;
  std::string report_folder;
  bool force = false;
  BuildOutputFlags printed;
};

BuildResult BuildFrom(const MapBuildFlags& flags, const BuildOptions& options) {
  const std::optional<GivenPoses> poses = PosesOf(flags.build);
  return BuildWithProgress(OpenSources(flags.build.sources, options.layers, flags.printed.quiet),
                           options, flags.printed, poses);
}

void PrintSummary(const MapBuildFlags& flags, const BuildResult& result) {
  BuildSummary summary;
  summary.path = flags.output;
  summary.version = ReadMap(flags.output, {.images = false}).info.version;
  summary.bytes = std::filesystem::file_size(flags.output);
  summary.tables = TableSizes(flags.output);
  summary.result = &result;
  if (flags.printed.json) {
    std::cout << Dump(SummaryJson(summary)) << '\n';
  } else if (!flags.printed.quiet) {
    std::cout << SummaryText(summary);
  }
}

// What people added to the map that is replaced.
struct GivenToOldMap {
  std::optional<std::string> names;
  std::optional<KeptPlans> plans;
};

GivenToOldMap ReadOldMap(const std::string& path) {
  if (!std::filesystem::exists(path)) return {};
  try {
    return {NamesOfOldMap(path), PlansOfOldMap(path)};
  } catch (const MapError& error) {
    std::cerr << "waystone: the new map won't have the names and floor plans of the old one, if "
                 "it has any, unless you stop now and restore a backup: "
              << Printable(error.what()) << '\n';
    return {};
  }
}

void KeepOldNames(const std::string& names, const std::string& path, MapData& map) {
  const std::optional<std::filesystem::path> kept_apart = KeepNames(names, path, map);
  if (!kept_apart) return;
  std::cerr << "waystone: the new map has only some of the named places of the old one; all are in "
            << kept_apart->string() << " (waystone name " << path << " --from FILE lists them)\n";
}

void KeepOldPlans(const KeptPlans& plans, const std::string& path, MapData& map) {
  for (const PlanApart& apart : KeepPlans(plans, path, map)) {
    std::cerr << "waystone: the floor plan " << Printable(QuoteShortened(apart.name))
              << " is not in the new map: it was anchored " << Printable(apart.cause)
              << "; its image is in " << apart.image.string() << " (waystone plan " << path
              << " IMAGE --anchor ... takes it again)\n";
  }
}

void CheckReport(const MapBuildFlags& flags) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::path folder = fs::weakly_canonical(flags.report_folder, ignored);
  if (folder == fs::weakly_canonical(flags.output, ignored)) {
    throw MapError(ErrorCode::kUsage, "-o and --report are both " + flags.output +
                                          "; choose another folder for the report");
  }
  for (const std::string& source : flags.build.sources.paths) {
    CheckIsNotInput(folder, source, "the folder of a source");
  }
  CheckReportFolder(flags.report_folder);
}

// After the map is written.
void WriteMapReport(const MapBuildFlags& flags, const BuildResult& result) {
  try {
    WriteReport(result.map, result.report, TableSizes(flags.output), flags.report_folder);
  } catch (const MapError& error) {
    throw MapError(error.code(), "the map was written to " + flags.output +
                                     ", but not its report: " + error.what());
  }
}

int RunBuild(const MapBuildFlags& flags) {
  EndAtInterrupts();
  const WriteOptions write{.overwrite = flags.force};
  const BuildOptions options = MakeBuildOptions(flags.build, MapNameOf(flags.output));
  CheckWritable(flags.output, write);
  if (!flags.report_folder.empty()) CheckReport(flags);
  const MapLock lock(flags.output);  // names added meanwhile would be lost
  const GivenToOldMap old = ReadOldMap(flags.output);
  BuildResult result = BuildFrom(flags, options);
  if (!CanAnswer(result)) return ReportNoPlanes(result.map);
  NoteInterrupts();
  if (old.names) KeepOldNames(*old.names, flags.output, result.map);
  if (old.plans) KeepOldPlans(*old.plans, flags.output, result.map);
  WriteMap(result.map, flags.output, write);
  if (!flags.report_folder.empty()) WriteMapReport(flags, result);
  PrintSummary(flags, result);
  return 0;
}

}  // namespace

void AddBuild(CLI::App& app, Run& run) {
  auto flags = std::make_shared<MapBuildFlags>();
  CLI::App* command = app.add_subcommand("build", "Build a map from image sequences");
  AddSourceFlags(*command, kBuildSources, flags->build.sources);
  command->add_option("-o,--output", flags->output, "Output map file")->required();
  AddBuildFlags(*command, flags->build);
  AddThreadsFlag(*command, flags->build.build.threads);
  command->add_flag("--force", flags->force,
                    "Overwrite an existing map file; no other file is overwritten");
  command->add_option("--report", flags->report_folder, "Write an HTML report to this folder");
  AddBuildOutputFlags(*command, flags->printed);
  command->footer(
      "Example: waystone build kitchen.mp4 -o kitchen.db --report kitchen-report\n"
      "         waystone build panoramas/ -o lab.db --layers appearance\n"
      "         waystone build walk/ -o walk.db --camera cam.yaml --layers planes,orientation");
  command->callback([flags, &run] { run = [flags] { return RunBuild(*flags); }; });
}

}  // namespace waystone
