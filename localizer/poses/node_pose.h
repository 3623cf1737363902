// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "localizer/index/map_index.h"
#include "localizer/verdict/answer.h"
#include "schema/layers/poses/pose_layer.h"

namespace waystone {

// Whether an answer of the appearance layer rests on features (PoseLayer::verified_errors) and not
// only on appearance. Pure; thread-safe.
bool IsVerified(const PanoramaAnswer& panorama);

// The assumed errors of answers where their map has too few panoramas to measure them; `spacing`:
// of its nodes, in the layer's unit. Pure; thread-safe.
NodePoseErrors DefaultNodePoseErrors(double spacing, bool verified);

// The pose of a query in the frame of the map's pose layer from the appearance layer's answer:
// position on the ground as answered, height as that of the nodes around it, and rotation by the
// relative pose to the best node, or else by the heading only, upright. The covariance is the
// answer's own, enlarged by `errors`. Nothing where the nearest node has no pose or the heading
// isn't known. The map has a pose layer (WS_CHECK). Deterministic; thread-safe.
std::optional<QueryPose> EstimateNodePose(const MapIndex& index, const Answer& answer,
                                          const NodePoseErrors& errors);

// Adds to an answer of the appearance layer the query's pose, or why there is none. Nothing is
// added for a map without poses, and the verdict never changes. Deterministic; thread-safe.
void AddNodePose(const MapIndex& index, Answer& answer);

}  // namespace waystone
