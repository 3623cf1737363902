// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <iostream>

#include "bench/accuracy/common.h"
#include "core/base/error.h"

namespace waystone::bench {

int RunLinear(const Args& args) {
  if (args.size() < 2) throw MapError(ErrorCode::kUsage, "linear wants a source and frame counts");
  nlohmann::ordered_json json = {{"bench", "linear"}, {"runs", nlohmann::ordered_json::array()}};
  std::vector<double> per_frame;
  for (size_t i = 1; i < args.size(); ++i) {
    const int frames = std::stoi(args[i]);
    const BuildReport whole = BuildRange(args[0], {0, frames - 1, 1}).report;
    const PlaneReport& report = whole.planes.value();
    per_frame.push_back(whole.total_s / report.frames);
    std::printf("%5d frames: %6.1f s, %.1f ms a frame (fusion %.2f s)\n", report.frames,
                whole.total_s, 1000 * per_frame.back(), report.fusion_s);
    json["runs"].push_back({{"frames", report.frames},
                            {"total_s", whole.total_s},
                            {"fusion_s", report.fusion_s},
                            {"ms_per_frame", 1000 * per_frame.back()}});
  }
  const auto [least, most] = std::minmax_element(per_frame.begin(), per_frame.end());
  json["spread"] = *most / *least - 1;
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
