// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <string>
#include <vector>

#include "core/base/text.h"
#include "schema/layers/layer_problems.h"

namespace waystone {
namespace {

void CheckImage(const FloorPlanImage& plan, const std::string& where,
                std::vector<MapProblem>& problems) {
  if (plan.image.empty()) return;  // read without pictures
  const PlanImageSize size = InspectPlanImage(plan.image);
  if (!size.problem.empty()) {
    problems.push_back({where, "its image: " + size.problem});
  } else if (size.width != plan.width || size.height != plan.height) {
    problems.push_back({where, "its image has " + SizeText(size.width, size.height) +
                                   " px; expected " + SizeText(plan.width, plan.height) + " px"});
  }
}

void CheckHeights(const MapData& map, const FloorPlanImage& plan, const std::string& where,
                  std::vector<MapProblem>& problems) {
  if (!plan.heights) return;
  const PlanHeights& heights = *plan.heights;
  const bool sound = std::abs(heights.low) <= kMaxPlanHeight &&
                     std::abs(heights.high) <= kMaxPlanHeight && heights.low < heights.high;
  if (!sound) problems.push_back({where, "its heights are no range within 1e9"});
  if (!map.poses) problems.push_back({where, "has heights, and the map has no pose layer"});
}

}  // namespace

void FindFloorPlanProblems(const MapData& map, std::vector<MapProblem>& problems) {
  if (map.floor_plans.empty()) return;
  if (!map.poses && !map.appearance) {
    problems.push_back({"floor_plans", "the map has no positions for them"});
  }
  if (map.floor_plans.size() > kMaxFloorPlans) {
    problems.push_back({"floor_plans", std::to_string(map.floor_plans.size()) +
                                           " plans; a map holds at most " +
                                           std::to_string(kMaxFloorPlans)});
  }
  const std::string* last = nullptr;
  for (const FloorPlanImage& plan : map.floor_plans) {
    const std::string where = "floor plan '" + Printable(plan.name.substr(0, 80)) + "'";
    if (const auto problem = FindNameProblem(plan.name)) {
      problems.push_back({where, "its name " + *problem});
    }
    if (last && !(*last < plan.name)) problems.push_back({where, "isn't in order of the names"});
    last = &plan.name;
    if (const auto problem = FindAnchorProblem(plan.anchors, plan.width, plan.height)) {
      problems.push_back({where, *problem});
    }
    CheckHeights(map, plan, where, problems);
    CheckImage(plan, where, problems);
  }
}

}  // namespace waystone
