// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "builder/build_map.h"
#include "builder/sources/source.h"
#include "cli/files/given_poses.h"

// What `build` and `add` have in common: sources, and building with progress.
namespace waystone {

// Exit status for a map without any layer that can answer.
inline constexpr int kBelowQualityGate = 4;

struct SourceFlags {
  std::vector<std::string> paths;
  SourceOptions options;
  int to = -1;         // -1: up to the last frame
  std::string camera;  // empty: none
};

struct BuildOutputFlags {
  std::string progress = "auto";
  bool json = false;
  bool quiet = false;
};

// `kinds` says which sources are accepted, for --help.
void AddSourceFlags(CLI::App& command, const std::string& kinds, SourceFlags& flags);
void AddThreadsFlag(CLI::App& command, int& threads);
// Adds --poses and the flags that say how the poses are meant.
void AddPoseFlags(CLI::App& command, PoseFlags& flags);
// Adds --json, --quiet and --progress.
void AddBuildOutputFlags(CLI::App& command, BuildOutputFlags& flags);

// Throws MapError(kBadOptions).
SourceOptions SourceOptionsOf(const SourceFlags& flags);

// Opens all sources, and announces each with its layers unless `quiet`. Throws as OpenSource does.
std::vector<std::unique_ptr<Source>> OpenSources(const SourceFlags& flags,
                                                 const LayerChoice& layers, bool quiet);

// BuildMap, with progress on stderr. Throws as BuildMap does; kInterrupted after a signal
// (NoteInterrupts).
BuildResult BuildWithProgress(const std::vector<std::unique_ptr<Source>>& sources,
                              const BuildOptions& options, const BuildOutputFlags& flags,
                              const std::optional<GivenPoses>& poses,
                              BuiltFeatures features = BuiltFeatures::kDrop);

// Whether a photo can be found in the map by planes or landmarks.
bool HasPlanesOrLandmarks(const MapData& map);
// The message that none was found, and what to do.
std::string NoPlanesText(const MapData& map);
// Prints it to stderr, and returns the exit status.
int ReportNoPlanes(const MapData& map);

}  // namespace waystone
