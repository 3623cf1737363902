// SPDX-License-Identifier: Apache-2.0
#include "localizer/index/floor_plan_finder.h"

#include <algorithm>
#include <limits>

namespace waystone {

FloorPlanFinder::FloorPlanFinder(const MapData& map) {
  if (map.floor_plans.empty()) return;
  if (map.poses) view_ = HorizontalOf(*map.poses);
  for (const FloorPlanImage& plan : map.floor_plans) {
    plans_.push_back({plan.name, plan.width, plan.height, plan.heights, FitPlan(plan.anchors)});
  }
  std::ranges::stable_sort(plans_, {}, [](const Fitted& plan) {
    return plan.heights ? plan.heights->high - plan.heights->low
                        : std::numeric_limits<double>::infinity();
  });
}

std::optional<PlanPosition> FloorPlanFinder::Find(const Eigen::Vector3d& in_pose_layer) const {
  if (!view_) return std::nullopt;
  return Find(view_->Of(in_pose_layer), view_->up.dot(in_pose_layer));
}

std::optional<PlanPosition> FloorPlanFinder::Find(const Pose2& in_appearance_layer) const {
  if (view_) return std::nullopt;
  return Find(Eigen::Vector2d(in_appearance_layer.x, in_appearance_layer.y), std::nullopt);
}

std::optional<PlanPosition> FloorPlanFinder::Find(const Eigen::Vector2d& at,
                                                  std::optional<double> height) const {
  for (const Fitted& plan : plans_) {
    if (plan.heights && !(height && plan.heights->Hold(*height))) continue;
    const Eigen::Vector2d px = plan.fit.Of(at);
    const bool inside = px.x() >= 0 && px.x() <= plan.width && px.y() >= 0 && px.y() <= plan.height;
    if (inside) return PlanPosition{plan.name, px};
  }
  return std::nullopt;
}

}  // namespace waystone
