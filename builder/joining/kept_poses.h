// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <map>
#include <utility>

#include "schema/map_data.h"

namespace waystone {

// Where the features of a map's planes were before planes are fused or lose views, for the pose
// layer. Immutable after construction.
class PosesBefore {
 public:
  explicit PosesBefore(const MapData& map);

  // Reduces the pose layer to what the map still has, and gives each feature of a plane its depth:
  // the old one where plane, reference image and position are unchanged, and else that at which the
  // feature's ray meets the fitted plane. A feature of a plane without a fit gets none. A layer
  // without poses is removed.
  void KeepPoses(MapData& map) const;

 private:
  struct PlaneBefore {
    KeyframeId reference;
    std::map<std::pair<float, float>, DepthCode> depths;  // by position in the reference image
  };

  std::map<PlaneId, PlaneBefore> planes_;
};

}  // namespace waystone
