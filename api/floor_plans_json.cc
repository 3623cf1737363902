// SPDX-License-Identifier: Apache-2.0
#include "api/floor_plans_json.h"

#include "api/names_file.h"
#include "core/base/text.h"

namespace waystone {
namespace {

Json PairJson(const Eigen::Vector2d& point) { return {point.x(), point.y()}; }

Json RowsJson(const Eigen::Matrix<double, 2, 3>& matrix) {
  Json rows = Json::array();
  for (int row = 0; row < 2; ++row) {
    rows.push_back({matrix(row, 0), matrix(row, 1), matrix(row, 2)});
  }
  return rows;
}

Json FloorPlanJson(const std::string& map_name, const FloorPlanImage& plan) {
  const PlanFit fit = FitPlan(plan.anchors);
  Json json;
  json["name"] = plan.name;
  json["width"] = plan.width;
  json["height"] = plan.height;
  json["image"] =
      "/v1/maps/" + EncodeSegment(map_name) + "/plan/image?name=" + EncodeSegment(plan.name);
  json["heights"] = nullptr;
  if (plan.heights) json["heights"] = {{"low", plan.heights->low}, {"high", plan.heights->high}};
  json["plan_from_frame"] = RowsJson(fit.plan_from_frame);
  json["px_per_unit"] = Rounded(fit.px_per_unit, 9);
  json["residual"] = Rounded(fit.residual_px / fit.px_per_unit, 6);
  json["anchors"] = Json::array();
  for (const PlanAnchor& anchor : plan.anchors) {
    json["anchors"].push_back({{"px", PairJson(anchor.px)}, {"at", PairJson(anchor.at)}});
  }
  return json;
}

}  // namespace

Json FloorPlansJson(const std::string& map_name, const MapData& map) {
  Json json = AreaFrameJson(map);
  json["plans"] = Json::array();
  for (const FloorPlanImage& plan : map.floor_plans) {
    json["plans"].push_back(FloorPlanJson(map_name, plan));
  }
  return json;
}

}  // namespace waystone
