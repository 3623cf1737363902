// SPDX-License-Identifier: Apache-2.0
#include "builder/build_options.h"

#include <nlohmann/json.hpp>

#include "core/base/error.h"

namespace waystone {

std::string OptionsJson(const BuildOptions& options) {
  const PlaneLayerOptions& planes = options.planes;
  const nlohmann::ordered_json json = {
      {"features",
       {{"type", NameOf(options.features.type)},
        {"max_features", options.features.max_features},
        {"contrast_threshold", options.features.contrast_threshold}}},
      {"keyframes",
       {{"min_matches_last", options.keyframes.min_matches_last},
        {"min_matches_before_last", options.keyframes.min_matches_before_last},
        {"min_matches_stretch", options.keyframes.min_matches_stretch}}},
      {"planes",
       {{"seed", planes.seed},
        {"max_ratio", planes.match.max_ratio},
        {"max_error_px", planes.segmentation.ransac.max_error_px},
        {"min_inliers", planes.segmentation.min_inliers},
        {"min_vote_share", planes.min_vote_share},
        {"plenty_of_features", planes.plenty_of_features},
        {"votes_in_plenty", planes.votes_in_plenty},
        {"min_features", planes.min_features}}},
      {"appearance",
       {{"rows", options.appearance.describe.signature.rows},
        {"k1", options.appearance.describe.signature.k1},
        {"k2", options.appearance.describe.signature.k2},
        {"node_features", options.appearance.describe.features.max_kept},
        {"max_span", options.appearance.odometry.max_span},
        {"close_loops", options.appearance.close_loops},
        {"max_loss", options.appearance.redundancy.max_loss}}},
      {"orientation",
       {{"step", options.orientation.step},
        {"detector", NameOf(options.orientation.segments.detector)},
        {"max_kept", options.orientation.bearings.max_kept}}}};
  return json.dump();
}

void BuildOptions::Check() const {
  features.Check();
  keyframes.Check();
  planes.Check();
  appearance.Check();
  orientation.Check();
  calibration.Check();
  appearance_calibration.Check();
  if (image_width < 16 || image_width > 4096) {
    throw MapError(ErrorCode::kBadOptions, "image_width is " + std::to_string(image_width) +
                                               "; it must be between 16 and 4096");
  }
  if (threads < 0 || threads > 1024) {
    throw MapError(ErrorCode::kBadOptions, "threads is " + std::to_string(threads) +
                                               "; it must be between 0 (one per core) and 1024");
  }
}

}  // namespace waystone
