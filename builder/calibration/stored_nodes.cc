// SPDX-License-Identifier: Apache-2.0
#include "builder/calibration/stored_nodes.h"

#include <algorithm>

#include "builder/calibration/node_pose_calibration.h"
#include "core/base/check.h"
#include "localizer/index/node_bearings.h"

namespace waystone {

void RecalibrateAppearanceLayer(MapData& map, const AppearanceCalibrationOptions& options) {
  WS_CHECK(map.appearance.has_value(), "the map has no appearance layer");
  const std::vector<AppearanceNode>& nodes = map.appearance->nodes;
  const size_t count = std::min(nodes.size(), static_cast<size_t>(options.max_nodes));
  std::vector<AppearanceSampleFrame> samples;
  for (size_t i = 0; i < count; ++i) {
    const size_t at = i * nodes.size() / count;
    const AppearanceNode& node = nodes[at];
    AppearanceSampleFrame& sample = samples.emplace_back();
    sample.signature = node.signature;
    if (!node.features.bearings.empty()) {
      sample.features = ToBearingFeatures(node.features, map.info.feature_type);
    }
    sample.pose = node.pose;
    sample.node = static_cast<int>(at);
    sample.sequence = node.sequence;
    sample.info = {node.frame, node.source, node.time_s};
  }
  map.appearance->verdict.reset();
  map.appearance->verified_verdict.reset();
  ProgressReporter nobody;
  CalibrateAppearanceLayer(map, samples, options, nobody);
  if (!map.poses || map.poses->nodes.empty()) return;
  map.poses->appearance_errors.reset();
  map.poses->verified_errors.reset();
  NodePoseReport report;
  MeasureNodePoseErrors(samples, options.query, map, report);
}

}  // namespace waystone
