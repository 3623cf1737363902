// SPDX-License-Identifier: Apache-2.0
#include "builder/options_record.h"

#include "builder/build_options.h"

namespace waystone {
namespace {

// Options of structs that don't list their fields.
nlohmann::ordered_json RecordChosen(const BuildOptions& options) {
  const PlaneLayerOptions& planes = options.planes;
  return {{"features",
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
}

}  // namespace

std::string RecordOptions(const BuildOptions& options) {
  nlohmann::ordered_json record = RecordChosen(options);
  record.merge_patch(RecordFields(options));
  return record.dump();
}

}  // namespace waystone
