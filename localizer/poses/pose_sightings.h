// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <vector>

#include "core/camera/camera.h"
#include "core/camera_pose/absolute_pose.h"
#include "core/features/features.h"
#include "localizer/index/map_index.h"
#include "localizer/verdict/answer.h"

namespace waystone {

// A query's matches as input for its pose: those whose features have a position in the frame of the
// map's pose layer, each once; those that share a keypoint share its weight. `sigma_rad`: standard
// deviation of the query's rays. Pure; thread-safe.
std::vector<PointSighting> MakePointSightings(const MapIndex& index, const Features& query,
                                              const Camera& camera, double sigma_rad,
                                              std::vector<MapMatch> matches);

// The `count` nearest keyframes with poses (indices in map().keyframes) that look in much the same
// direction as a camera, nearest first; only those that `admits` accepts, if given. The map has a
// pose layer. Thread-safe if `admits` is.
std::vector<int> NearestPosedKeyframes(const MapIndex& index,
                                       const Eigen::Isometry3d& frame_from_camera, int count,
                                       const std::function<bool(int)>& admits = nullptr);

}  // namespace waystone
