// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "builder/planes/keyframe_sample.h"
#include "builder/poses/add_poses.h"
#include "localizer/poses/pose_query_options.h"
#include "schema/map_data.h"

namespace waystone {

// How consistent the poses of a map's keyframes are: each of the `samples` with a pose is localized
// by the features of the nearest other keyframes, without those at most `neighbours` keyframes away
// in its sequence, since a query comes at another time. The difference between found and given
// poses, beyond what their covariances explain, is the noise: errors that all features of a
// keyframe share, and that a query's residuals don't show. Nothing is measured with fewer than 8
// such keyframes. Deterministic on any number of threads.
PoseNoiseReport MeasurePoseNoise(const MapData& map, const std::vector<SampledKeyframe>& samples,
                                 int neighbours, const PoseQueryOptions& options);

}  // namespace waystone
