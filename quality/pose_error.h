// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <map>
#include <optional>

#include "quality/place_id.h"

// Poses of answers against true ones, in a world of the truth's choice: its axes needn't be those
// of the map. Cameras have x right, y down, z forward.
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
// says: so that the errors of the map's own trajectory, which `eval trajectory` measures, don't
// count. An answer with a pose (Answer::pose, of a map with the pose layer `layer`) says by it how
// the camera is moved against its keyframe. Nothing for answers that aren't localized and places
// without a true pose.
std::optional<PoseError> ComparePose(const Answer& answer, const PlacePoses& poses,
                                     const std::optional<double>& metres_per_unit,
                                     const TruePose& truth,
                                     const std::optional<PoseLayer>& layer = std::nullopt);

// The poses of a map's own pose layer; empty without one.
PlacePoses PosesOfLayer(const MapData& map);

}  // namespace waystone
