// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "localizer/index/map_index.h"
#include "localizer/verdict/answer.h"
#include "schema/layers/poses/pose_layer.h"

namespace waystone {

// Whether an answer of the appearance layer rests on features (PoseLayer::verified_errors) and not
// on appearance alone.
bool IsVerified(const PanoramaAnswer& panorama);

// What is taken for the errors of answers where their map has too few panoramas to measure them;
// `spacing`: of its nodes, in the layer's unit.
NodePoseErrors DefaultNodePoseErrors(double spacing, bool verified);

// The pose of a query in the frame of the map's pose layer by what the appearance layer answered:
// on the ground as answered; as high as the nodes around; and turned as the relative pose against
// the best node says, or else by the heading alone, upright. The covariance is the answer's own,
// enlarged by `errors`. Nothing where the nearest node has no pose or the heading isn't known. The
// map has a pose layer (WS_CHECK). Deterministic; thread-safe.
std::optional<QueryPose> EstimateNodePose(const MapIndex& index, const Answer& answer,
                                          const NodePoseErrors& errors);

// Adds to an answer of the appearance layer the query's pose, or why there is none. Nothing is
// added for a map without poses, and the verdict never changes. Deterministic; thread-safe.
void AddNodePose(const MapIndex& index, Answer& answer);

}  // namespace waystone
