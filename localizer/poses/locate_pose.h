// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "core/camera/camera.h"
#include "core/features/features.h"
#include "localizer/index/map_index.h"
#include "localizer/poses/pose_query_options.h"
#include "localizer/verdict/answer.h"

namespace waystone {

// Adds to an answer of the plane layer the query's pose in the frame of the map's pose layer, or
// why there is none: from the matches of its place (PlaneAnswer::matches) whose features have a
// depth, and then from all features of the nearest keyframes that the query shows where this pose
// predicts them. A camera of another size than the query is ignored; without `camera`, that of the
// map's images is used where the query has their size. Nothing is added for a map without poses,
// and the verdict never changes. Deterministic; thread-safe.
void AddPose(const MapIndex& index, const Features& query, const std::optional<Camera>& camera,
             const PoseQueryOptions& options, Answer& answer);

}  // namespace waystone
