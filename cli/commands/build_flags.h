// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "builder/build_map.h"
#include "cli/commands/build_sources.h"
#include "cli/files/given_poses.h"
#include "cli/files/panorama_file.h"

// What a map is built from and how, for `build` and for the jobs of `enqueue`.
namespace waystone {

inline constexpr const char* kBuildSources =
    "Image folders, quoted globs, videos, TUM, KITTI or EuRoC sequences, panorama folders or rig "
    "folders";

struct BuildFlags {
  SourceFlags sources;
  std::string features = "sift";
  std::string layers = "auto";
  std::vector<std::string> settings;  // of --set
  PanoramaFlags panorama;
  PoseFlags poses;
  BuildOptions build;
  bool no_images = false;
};

// Adds all flags but the sources (AddSourceFlags) and the number of threads.
void AddBuildFlags(CLI::App& command, BuildFlags& flags);

// Throws MapError(kUsage, kBadOptions) for what no build accepts.
BuildOptions MakeBuildOptions(const BuildFlags& flags, const std::string& map_name);

// Nothing where none are given. Throws as ReadGivenPoses does.
std::optional<GivenPoses> PosesOf(const BuildFlags& flags);

// Whether the map has a layer that answers queries.
bool CanAnswer(const BuildResult& result);

// The given options of a command, as "--every=2", of those in `known` only: what ParseBuildFlags
// takes.
std::vector<std::string> GivenOptions(const std::vector<const CLI::Option*>& known);
// Throws MapError(kUsage) as the command line does.
BuildFlags ParseBuildFlags(const std::vector<std::string>& sources,
                           const std::vector<std::string>& options);

}  // namespace waystone
