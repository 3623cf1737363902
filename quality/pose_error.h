// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <map>
#include <optional>

#include "quality/place_id.h"

// Poses of answers compared with true ones, in the truth's own world frame, which needn't be the
// map's. Cameras have x right, y down, z forward. All functions are pure; thread-safe.
namespace waystone {

struct TruePose {
  Eigen::Isometry3d world_from_camera = Eigen::Isometry3d::Identity();  // metres
  bool has_rotation = false;
};

// Where the images of a map's places were taken.
using PlacePoses = std::map<PlaceId, TruePose>;

struct PoseError {
  double metres = 0;
  std::optional<double> rad;  // nothing where the answer or the truth has no heading
};

// Metres in one unit of the appearance layer: the layer's own scale, or else the median over its
// consecutive nodes whose true poses are known. Nothing where neither is known.
std::optional<double> MetresPerUnit(const MapData& map, const PlacePoses& poses);

// How far the pose of a localized answer is from where the query was taken. The answer's pose is
// the true pose of its place's image, moved and turned in the image's level frame as the answer
// states, so that errors of the map's own trajectory, which `eval trajectory` measures, don't
// count. For an answer with a pose (Answer::pose, of a map with the pose layer `layer`), that pose
// gives the camera's motion relative to its keyframe. Nothing for answers that aren't localized and
// places without a true pose.
std::optional<PoseError> ComparePose(const Answer& answer, const PlacePoses& poses,
                                     const std::optional<double>& metres_per_unit,
                                     const TruePose& truth,
                                     const std::optional<PoseLayer>& layer = std::nullopt);

// The poses of a map's own pose layer; empty without one.
PlacePoses PosesOfLayer(const MapData& map);

}  // namespace waystone
