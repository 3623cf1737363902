// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <iostream>
#include <map>

#include "bench/accuracy/common.h"
#include "core/base/error.h"

namespace waystone::bench {

int RunNegatives(const Args& raw) {
  Args args = raw;
  const Range map_range = ParseRange(TakeOption(args, "map", "0:499"));
  if (args.size() < 2) {
    throw MapError(ErrorCode::kUsage, "negatives wants a source for the map, then images");
  }
  const auto index = MapIndex::Build(BuildRange(args[0], map_range).map);
  std::map<std::string, int> verdicts;
  int photos = 0;
  int most_inliers = 0;
  for (size_t i = 1; i < args.size(); ++i) {
    for (const auto& path : ImagesIn(args[i])) {
      const Answer answer = Localize(*index, ReadBytes(path), path.string(), LocalizeOptions{});
      ++verdicts[NameOf(answer.verdict)];
      ++photos;
      if (answer.planes.runner_up)
        most_inliers = std::max(most_inliers, answer.planes.runner_up->inliers);
      if (answer.verdict != Verdict::kNotInMap) {
        std::printf("%s: %s, %d inliers\n", path.c_str(), NameOf(answer.verdict),
                    CountBestInliers(answer.planes));
      }
    }
  }
  const nlohmann::ordered_json json = {{"bench", "negatives"},
                                       {"photos", photos},
                                       {"verdicts", verdicts},
                                       {"most_inliers_refused", most_inliers}};
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
