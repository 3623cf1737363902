// SPDX-License-Identifier: Apache-2.0
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/graph_formats.h"
#include "builder/poses/keyframe_matches.h"
#include "builder/poses/keyframe_reader.h"
#include "builder/sources/source.h"
#include "cli/commands/commands.h"
#include "cli/files/colmap_database.h"
#include "cli/files/map_file.h"
#include "cli/files/output_file.h"
#include "cli/output/printable_output.h"
#include "cli/output/progress.h"
#include "cli/system/signals.h"
#include "core/base/error.h"
#include "schema/file/file_replacer.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr const char* kColmap = "colmap";
constexpr const char* kColmapDatabase = "database.db";
constexpr const char* kColmapImageList = "image_list.txt";

struct ExportFlags {
  std::string map;
  std::string format = "graphml";
  std::string output;
  std::vector<std::string> images;
  std::optional<int> max_features;
  bool force = false;
  bool quiet = false;
  std::string progress = "auto";
};

std::vector<std::unique_ptr<Source>> OpenImages(const ExportFlags& flags) {
  std::vector<std::unique_ptr<Source>> sources;
  for (const std::string& path : flags.images) sources.push_back(OpenSource(path, {}));
  return sources;
}

// Writes the list of images that COLMAP's commands take as --image_list_path.
void WriteImageList(const MapData& map, const fs::path& path, bool overwrite) {
  FileReplacer file(path, overwrite);
  std::ofstream out(file.temporary(), std::ios::binary);
  for (const Keyframe& keyframe : map.keyframes) out << ColmapImageName(map, keyframe) << '\n';
  if (!out.flush()) throw UnwritableError(path, std::strerror(errno), 0);
  file.Commit();
}

void CheckColmapFlags(const ExportFlags& flags, const MapData& map) {
  if (flags.images.empty() || flags.output.empty()) {
    throw MapError(ErrorCode::kUsage,
                   "the format colmap writes features of the map's images into a folder; specify "
                   "them with --images and the folder with -o");
  }
  if (map.keyframes.empty()) {
    throw MapError(ErrorCode::kNotAvailable,
                   flags.map +
                       " has no keyframes, and COLMAP does not support panoramas; use tum, g2o or "
                       "ply for the poses of panoramas");
  }
}

// Throws for an unwritable folder before an hour of work, not after.
void CheckColmapFolder(const fs::path& folder, bool overwrite) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw UnwritableError(folder, error.message(), 0);
  for (const char* file : {kColmapDatabase, kColmapImageList}) {
    CheckReplacesNoMap(folder / file);
    const FileReplacer writable(folder / file, overwrite);
  }
}

// A project for `colmap mapper`: the map's keyframes and their verified matches.
int RunColmapExport(const ExportFlags& flags) {
  const OpenMap open = OpenMapFile(flags.map, false);
  const MapData& map = open.index->map();
  CheckColmapFlags(flags, map);
  const std::vector<std::unique_ptr<Source>> images = OpenImages(flags);
  const fs::path folder = flags.output;
  CheckColmapFolder(folder, flags.force);
  NoteInterrupts();
  ProgressMeter meter(RawErrors(), ProgressStyleByName(flags.progress, flags.quiet),
                      ColoursWelcome());
  const auto show = [&meter](const BuildProgress& now) {
    meter.Update({now.stage, now.done, now.total, ""});
    return !Interrupted();
  };
  FeatureOptions features;
  features.type = map.info.feature_type;
  features.max_features = flags.max_features.value_or(kReconstructionFeatures);
  ColmapProject project{&map, ReadKeyframes(map, images, features, show), {}};
  project.matches = MatchKeyframes(*open.index, project.features, show);
  meter.Finish();
  WriteColmapDatabase(project, folder / kColmapDatabase, flags.force);
  WriteImageList(map, folder / kColmapImageList, flags.force);
  if (!flags.quiet) {
    std::cout << (folder / kColmapDatabase).string() << ": " << map.keyframes.size() << " images, "
              << project.matches.size() << " matched pairs\n";
  }
  return 0;
}

int RunExport(const ExportFlags& flags) {
  if (flags.format == kColmap) return RunColmapExport(flags);
  if (!flags.images.empty() || flags.max_features) {
    throw MapError(ErrorCode::kUsage,
                   "--images and --max-features are for --format colmap, and the format is " +
                       flags.format + "; omit them or specify colmap");
  }
  const OpenMap map = OpenMapFile(flags.map, false);
  const GraphText text = FormatGraph(*map.index, flags.format);
  if (flags.output.empty()) {
    std::cout << text.text << std::flush;
    return 0;
  }
  CheckIsNotInput(flags.output, flags.map, "the map that is exported");
  CheckReplacesNoMap(flags.output);
  FileReplacer file(flags.output, flags.force);
  std::ofstream out(file.temporary(), std::ios::binary);
  if (!(out << text.text).flush()) throw UnwritableError(flags.output, std::strerror(errno), 0);
  file.Commit();
  return 0;
}

std::vector<std::string> FormatNames() {
  std::vector<std::string> names = GraphFormatNames();
  names.emplace_back(kColmap);
  return names;
}

}  // namespace

void AddExport(CLI::App& app, Run& run) {
  auto flags = std::make_shared<ExportFlags>();
  CLI::App* command = app.add_subcommand("export", "Export a map to other formats");
  command->add_option("map", flags->map, "Map file")->required();
  command->add_option("--format", flags->format, "Output format")
      ->capture_default_str()
      ->check(CLI::IsMember(FormatNames()));
  command->add_option("-o,--output", flags->output,
                      "Output file, default: stdout; for colmap a folder");
  command->add_option("--images", flags->images,
                      "colmap: what the map was built from, in the order of the build");
  command->add_option("--max-features", flags->max_features, "colmap: maximum features per image")
      ->default_str(std::to_string(kReconstructionFeatures));
  command->add_flag("--quiet", flags->quiet, "Print errors only");
  command->add_option("--progress", flags->progress, "Progress on stderr: auto, none or json")
      ->capture_default_str();
  command->add_flag("--force", flags->force, "Overwrite existing files");
  command->footer(
      "graphml and dot contain the graph of planes; g2o, tum, ply, geojson and poses contain the\n"
      "poses of the appearance layer (maps of panoramas), geojson also the keyframes of maps with\n"
      "poses. colmap writes a project for `colmap mapper`, which reconstructs poses of the\n"
      "keyframes (docs/poses.md).\n"
      "Example: waystone export lab.db --format graphml -o lab.graphml\n"
      "         waystone export walk.db --format colmap --images walk.mp4 -o walk-colmap");
  command->callback([flags, &run] { run = [flags] { return RunExport(*flags); }; });
}

}  // namespace waystone
