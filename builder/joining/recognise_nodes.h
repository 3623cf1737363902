// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "builder/appearance/loop_closure.h"
#include "core/geometry/pose2.h"
#include "localizer/appearance/panorama_query_options.h"
#include "localizer/verdict/answer.h"
#include "schema/map_data.h"

namespace waystone {

// A panorama that shows a place of another map.
struct RecognisedNode {
  size_t asking = 0;          // index in the nodes that were queried
  size_t found = 0;           // index in the other map's nodes: the nearest one
  Pose2 pose;                 // in the other map's layer, in its units
  double position_sigma = 0;  // along its worst direction
  double heading_sigma_rad = 0;
  // The other map's best fitting node, and its relation to the asking one by their features.
  size_t best = 0;
  std::optional<Eigen::Matrix3d> asking_from_best = {};
  int inliers = 0;
  std::optional<QueryPose> in_frame = {};  // in the other map's frame, where it has poses
};

// Which panoramas of `other` show places of `map`: each is localized by the signature and the
// features that its map keeps. As within one build (LoopOptions), an answer counts only where
// neighbours in its sequence are localized near it and turned as they are in their own map. In the
// order of the nodes; the same on any number of threads. `query` has the options of the queries.
// Both have appearance layers that describe panoramas alike (WS_CHECK).
std::vector<RecognisedNode> RecogniseNodes(const MapData& map, const MapData& other,
                                           const LoopOptions& options,
                                           const PanoramaQueryOptions& query);

}  // namespace waystone
