// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <map>

#include "bench/accuracy/benches.h"
#include "core/base/error.h"

namespace {

constexpr char kUsage[] =
    "usage: waystone-bench NAME ARGS\n"
    "  all                                                all of these\n"
    "  world [--frames N] [--plan demo|other]               planes against rendered truth\n"
    "  rgbd DIR [--map 0:499] [--queries 500:990:10]      localization against depth and poses\n"
    "  negatives DIR [--map 0:499] IMAGE_OR_FOLDER...     images that are not in the map\n"
    "  pairs DIR... [--labels OUT]                        planes in two images against labels\n"
    "  verdicts [DATA]                                    false answers, reliability\n"
    "  linear DIR N...                                    seconds per frame over N frames\n"
    "  build SOURCE... [--frames 250,500,1000]            whole builds against features alone\n"
    "  graphs [SOURCE...] [--keyframes M:N]               image graph against plane graph\n"
    "  scale [N...]                                       queries of maps of N features\n"
    "The last line of each is one JSON object.\n";

}  // namespace

int main(int argc, char** argv) {
  using waystone::bench::Args;
  const std::map<std::string, int (*)(const Args&)> benches = {
      {"all", waystone::bench::RunAll},       {"world", waystone::bench::RunWorld},
      {"rgbd", waystone::bench::RunRgbd},     {"negatives", waystone::bench::RunNegatives},
      {"linear", waystone::bench::RunLinear}, {"build", waystone::bench::RunBuild},
      {"graphs", waystone::bench::RunGraphs}, {"pairs", waystone::bench::RunPairs},
      {"scale", waystone::bench::RunScale},   {"verdicts", waystone::bench::RunVerdicts}};
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
