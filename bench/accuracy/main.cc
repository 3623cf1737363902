// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <map>

#include "bench/accuracy/benches.h"
#include "core/base/error.h"

namespace {

constexpr char kUsage[] =
    "usage: waystone-bench NAME ARGS\n"
    "  world [--frames N] [--plan demo|other] [--set N=V]   planes against rendered truth\n"
    "  rgbd DIR [--map 0:499] [--queries 500:990:10]      localization against depth and poses\n"
    "  pairs DIR... [--labels OUT] [--set N=V]            planes in two images against labels\n"
    "  rendered-pairs [--pairs N] [--first SEED] [--set N=V]  the same against rendered truth\n"
    "  homographies DIR... [--set N=V]                    corners of flat scenes against truth\n"
    "  verdicts [DATA]                                    false answers, reliability\n"
    "  directions [DIR...] [--photos]                     Manhattan frames against truth\n"
    "  segments IMAGE_OR_FOLDER...                        segment detectors\n"
    "  recall [DATA] [--only NAME] [--landmarks N,N]      found by image search and by maps\n"
    "  peers [DATA] [--only NAME] [--features sift,orb]   maps beside plain image search\n"
    "  cameras [DATA] [--only NAME] [--foreign N]         photos of other cameras, in other light\n"
    "  look-alikes [--buildings N] [--first SEED]         storeys that share posters and doors\n"
    "  storeys [DATA] [--buildings N] [--first SEED]      several look-alike storeys in one map\n"
    "  collection [DATA] [--maps N,N] [--features sift]   the right one of many maps\n"
    "  relative [DIR]                                     rotations between places\n"
    "  orientation [--buildings 3] [--frames 1000]        turns, corridors, loops, nodes\n"
    "  joining DATA [--only NAME] [--frames 5000]         maps of halves beside the whole\n"
    "  visits DATA [--visits 9]                           one place, mapped again and again\n"
    "  joining-panoramas [PLACES] [--flats 4]             the same for panoramas\n"
    "  linear DIR N...                                    seconds per frame over N frames\n"
    "  campus N...                                        N buildings in one map\n"
    "  build SOURCE... [--frames 250,500,1000]            whole builds against features alone\n"
    "  graphs [SOURCE...] [--keyframes M:N]               image graph against plane graph\n"
    "  poses [--buildings N] [--flats N] [--kitchen DIR] [--church DIR] [--panoramas DIR]\n"
    "                                                     poses of queries\n"
    "  reconstruction KITCHEN                             poses by COLMAP from an exported map\n"
    "  scale [N...]                                       queries of maps of N features\n"
    "  compass [PLACES] [--csv PREFIX]                    headings between panoramas\n"
    "  page [N...]                                        the page on maps of N planes\n"
    "  serve [MAP PHOTO...]                               queries and inspection over HTTP\n"
    "  odometry [PLACES] [--walk NAME] [--k1 N] [--span N]  trajectories of panoramas against "
    "truth\n"
    "  study [--out DIR]                                  k1, k2 and step of these trajectories\n"
    "  building KITCHEN DEALERSHIP                        rotation in the building, axes as a "
    "gate\n"
    "  kidnapped [PLACES]                                 panoramas asked of a map of the others\n"
    "The last line of each is one JSON object. scripts/bench.py runs those of "
    "docs/benchmarks.md.\n";

}  // namespace

int main(int argc, char** argv) {
  using waystone::bench::Args;
  const std::map<std::string, int (*)(const Args&)> benches = {
      {"compass", waystone::bench::RunCompass},
      {"building", waystone::bench::RunBuilding},
      {"cameras", waystone::bench::RunCameras},
      {"collection", waystone::bench::RunCollection},
      {"kidnapped", waystone::bench::RunKidnapped},
      {"world", waystone::bench::RunWorld},
      {"rgbd", waystone::bench::RunRgbd},
      {"look-alikes", waystone::bench::RunLookAlikes},
      {"linear", waystone::bench::RunLinear},
      {"campus", waystone::bench::RunCampus},
      {"build", waystone::bench::RunBuild},
      {"graphs", waystone::bench::RunGraphs},
      {"pairs", waystone::bench::RunPairs},
      {"rendered-pairs", waystone::bench::RunRenderedPairs},
      {"homographies", waystone::bench::RunHomographies},
      {"orientation", waystone::bench::RunOrientation},
      {"directions", waystone::bench::RunDirections},
      {"segments", waystone::bench::RunSegments},
      {"odometry", waystone::bench::RunOdometry},
      {"peers", waystone::bench::RunPeers},
      {"recall", waystone::bench::RunRecall},
      {"relative", waystone::bench::RunRelative},
      {"poses", waystone::bench::RunPoses},
      {"joining", waystone::bench::RunJoining},
      {"joining-panoramas", waystone::bench::RunJoiningPanoramas},
      {"reconstruction", waystone::bench::RunReconstruction},
      {"scale", waystone::bench::RunScale},
      {"serve", waystone::bench::RunServe},
      {"storeys", waystone::bench::RunStoreys},
      {"study", waystone::bench::RunStudy},
      {"verdicts", waystone::bench::RunVerdicts},
      {"visits", waystone::bench::RunVisits},
      {"page", waystone::bench::RunPage}};
  if (argc < 2 || !benches.contains(argv[1])) {
    std::cerr << kUsage;
    return 2;
  }
  try {
    return benches.at(argv[1])(Args(argv + 2, argv + argc));
  } catch (const waystone::MapError& error) {
    std::cerr << "waystone-bench: " << error.what() << "\n";
    return InfoOf(error.code()).exit_code;
  } catch (const std::exception& error) {
    std::cerr << "waystone-bench: " << error.what() << "\n";
    return 5;
  }
}
