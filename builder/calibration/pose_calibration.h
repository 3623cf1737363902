// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "builder/planes/keyframe_sample.h"
#include "builder/poses/add_poses.h"
#include "localizer/poses/pose_query_options.h"
#include "schema/map_data.h"

namespace waystone {

// How far the poses of a map's keyframes are from one another: those of the `samples` that have a
// pose are posed by the features of the nearest others, those left out that are at most
// `neighbours` keyframes away in their sequence, since a query comes at another time. What the
// poses found and given differ by, beyond what their covariances explain, is the noise: errors that
// all features of a keyframe share, and that the residuals of a query don't show. Nothing is
// measured with fewer than 8 such keyframes. Deterministic on any number of threads.
PoseNoiseReport MeasurePoseNoise(const MapData& map, const std::vector<SampledKeyframe>& samples,
                                 int neighbours, const PoseQueryOptions& options);

}  // namespace waystone
