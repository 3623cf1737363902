// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/pose2.h"
#include "localizer/verdict/answer.h"
#include "schema/layers/poses/horizontal.h"
#include "schema/map_data.h"

namespace waystone {

// Where positions are on the floor plans of a map. Of several plans that show a position, the one
// with the narrowest range of heights counts; of equally narrow ones the first by name. Immutable;
// any number of threads may share it.
class FloorPlanFinder {
 public:
  FloorPlanFinder() = default;
  explicit FloorPlanFinder(const MapData& map);

  // For a position in the pose layer, or in the appearance layer of a map without one; nothing
  // where no plan has it within its heights and its image.
  std::optional<PlanPosition> Find(const Eigen::Vector3d& in_pose_layer) const;
  std::optional<PlanPosition> Find(const Pose2& in_appearance_layer) const;

 private:
  struct Fitted {
    std::string name;
    int width = 0;
    int height = 0;
    std::optional<PlanHeights> heights;
    PlanFit fit;
  };

  std::optional<PlanPosition> Find(const Eigen::Vector2d& at, std::optional<double> height) const;

  std::vector<Fitted> plans_;       // the narrowest first
  std::optional<Horizontal> view_;  // nothing without a pose layer
};

}  // namespace waystone
