// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/base/random.h"
#include "localizer/index/map_index.h"

namespace waystone {

// A place to look from: X_camera = r X_world - t, where the world is the camera's frame in
// keyframe 1.
struct MadePose {
  Eigen::Matrix3d r = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
};

// A made map of two surroundings. In the first, keyframes 1 to 4 go along with a wall in front
// (plane 1, seen by 1 to 3), one at the right (plane 2, seen by 1 to 4) and the floor (plane 3,
// seen by 3 and 4), with the edges 1-2 and 2-3. Keyframes 5 and 6 are somewhere else and see
// another wall (plane 4) alone. Each plane has 70 features with random descriptors. The reference
// image of planes 1 and 2 is keyframe 1, of plane 3 keyframe 3, of plane 4 keyframe 5.
inline constexpr int kMapFeatures = 70;
MapData MadeMap();
std::shared_ptr<const MapIndex> MadeIndex();

// The pose of a keyframe of the map, and one between two of them.
MadePose PoseOf(double keyframe);

// x_reference = H x_query for a plane (by its id) and a query's pose.
Eigen::Matrix3d ReferenceFromQuery(int64_t plane, const MadePose& query);

// What a camera sees from a pose: the features of the planes with the given ids that lie in its
// 640x480 image, noisy by 0.2 px, with their descriptors a little disturbed; and `clutter` features
// that are in no map. In random order.
Features QueryOf(const MapData& map, const std::vector<int64_t>& planes, const MadePose& pose,
                 int clutter, uint64_t seed);

// The same features in another order.
Features Shuffled(const Features& features, uint64_t seed);

// The first `count` features.
Features FirstFeatures(const Features& features, int count);

}  // namespace waystone
