// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "builder/appearance/describe_panorama.h"
#include "builder/appearance/loop_closure.h"
#include "builder/appearance/redundancy.h"
#include "builder/appearance/visual_odometry.h"
#include "core/base/options.h"
#include "core/pose_graph/pose_graph.h"

namespace waystone {

// Everything the layer is made with.
struct AppearanceOptions {
  DescribeOptions describe;
  VisualOdometryOptions odometry;
  LoopOptions loops;
  PoseGraphOptions graph;
  RedundancyOptions redundancy;
  bool close_loops = true;
  int max_samples = 60;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionGroup{"describe", &AppearanceOptions::describe},
        OptionGroup{"odometry", &AppearanceOptions::odometry},
        OptionGroup{"loops", &AppearanceOptions::loops},
        OptionGroup{"graph", &AppearanceOptions::graph},
        OptionGroup{"redundancy", &AppearanceOptions::redundancy},
        OptionField{"close_loops", &AppearanceOptions::close_loops, AnyValue(), "",
                    "Whether to close loops. Without loops, poses are those of the odometry."},
        OptionField{
            "max_samples", &AppearanceOptions::max_samples, Closed(0, 100'000), "",
            "Number of panoramas, spread evenly over all, whose features are kept in full for "
            "calibration. They take about 0.2 MB each while the map is built. Set by BuildMap.",
            OptionUse::kInternal});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

}  // namespace waystone
