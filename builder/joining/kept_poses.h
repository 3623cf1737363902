// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <map>
#include <utility>

#include "schema/map_data.h"

namespace waystone {

// Where the features of a map's planes were before planes are fused or lose views, for the pose
// layer.
class PosesBefore {
 public:
  explicit PosesBefore(const MapData& map);

  // Leaves in the pose layer what the map still has, and gives each feature of a plane its depth:
  // as before where plane, reference image and position are, and else where the feature's ray meets
  // the fitted plane. A feature of a plane that has no fit gets none. No layer is left without
  // poses.
  void KeepPoses(MapData& map) const;

 private:
  struct PlaneBefore {
    KeyframeId reference;
    std::map<std::pair<float, float>, DepthCode> depths;  // by position in the reference image
  };

  std::map<PlaneId, PlaneBefore> planes_;
};

}  // namespace waystone
