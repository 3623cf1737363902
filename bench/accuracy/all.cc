// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "bench/accuracy/common.h"
#include "core/base/error.h"

namespace waystone::bench {
namespace {

namespace fs = std::filesystem;

// Folder of the real data: WAYSTONE_DATA, or shared/data beside the project.
fs::path DataFolder() {
  const char* given = std::getenv("WAYSTONE_DATA");
  return given != nullptr ? fs::path(given) : fs::path("../shared/data");
}

void Announce(const std::string& title) {
  std::printf("\n== %s\n", title.c_str());
  (void)std::fflush(stdout);
}

}  // namespace

int RunAll(const Args& args) {
  if (!args.empty()) throw MapError(ErrorCode::kUsage, "all takes no arguments");
  Announce("world: planes against rendered truth, demo plan");
  RunWorld({});
  Announce("world: the other plan");
  RunWorld({"--plan", "other", "--seed", "2", "--frames", "500"});
  Announce("scale: queries of maps of 100,000 and 1,000,000 features");
  RunScale({});
  Announce("directions: Manhattan frames of rendered heads");
  RunDirections({});
  Announce("relative: rotations between rendered heads");
  RunRelative({});
  Announce("serve: queries and inspection over HTTP");
  RunServe({});
  Announce("orientation: turns, corridors, loops and nodes of made buildings");
  RunOrientation({});
  Announce("look-alikes: storeys that share posters and doors, and other buildings");
  RunLookAlikes({"--buildings", "8", "--first", "3"});
  const fs::path data = DataFolder();
  Announce("compass: headings between panoramas, by distance");
  const fs::path dealership = data / "dealership";
  RunCompass(fs::exists(dealership) ? Args{dealership} : Args{});
  Announce("kidnapped: panoramas asked of a map of all others");
  RunKidnapped(fs::exists(dealership) ? Args{dealership} : Args{});
  if (!fs::exists(data / "kitchen")) {
    std::printf("\nno real data in %s (set WAYSTONE_DATA to where it is): the rest is skipped\n",
                data.c_str());
    Announce("odometry: trajectories of rendered panoramas against their truth");
    RunOdometry({});
    Announce("verdicts: another made building against a map of the world");
    RunVerdicts({});
    Announce("tables I to III of the paper: world");
    return RunGraphs({"world"});
  }
  const std::string kitchen = data / "kitchen";
  Announce("labelled pairs: several planes in two images");
  Args pairs;
  for (const auto& folder : fs::directory_iterator(data / "labelled_pairs")) {
    pairs.push_back(folder.path());
  }
  std::sort(pairs.begin(), pairs.end());
  RunPairs(pairs);
  Announce("directions: Manhattan frames of photos and of six-camera heads");
  RunDirections({data / "york_urban", data / "dealership"});
  Announce("segments: detectors on photos");
  RunSegments({data / "york_urban/images"});
  Announce("relative: rotations between places of a walk, traversability");
  RunRelative({data / "dealership"});
  Announce("verdicts: photos of one place against maps of others");
  RunVerdicts({data});
  Announce("recall: places found by image search and by maps with and without landmarks");
  RunRecall({data});
  Announce("kitchen: frames 0-499 mapped, 50 queries against depth and poses");
  RunRgbd({kitchen});
  if (fs::exists(dealership)) {
    Announce("building: rotations of queries, and their axes as a gate");
    RunBuilding({kitchen, dealership});
  }
  Announce("kitchen's map: street and church are not in it");
  RunNegatives({kitchen, data / "street/image_0", data / "church/map", data / "church/query_P8"});
  Announce("kitchen: seconds per frame over 250, 500 and 1000 frames");
  RunLinear({kitchen, "250", "500", "1000"});
  Announce("kitchen: whole builds against features alone");
  RunBuild({kitchen, "--frames", "250,500,1000"});
  Announce("tables I to III of the paper: kitchen, church, world");
  return RunGraphs({kitchen, data / "church", "world"});
}

}  // namespace waystone::bench
