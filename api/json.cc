// SPDX-License-Identifier: Apache-2.0
#include "api/json.h"

#include <cmath>

namespace waystone {

std::string Dump(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string ToUtf8(const std::string& text) { return Json::parse(Dump(Json(text))); }

double Rounded(double value, int decimals) {
  const double scale = std::pow(10.0, decimals);
  return std::round(value * scale) / scale;
}

Json ToJson(const Eigen::Matrix3d& matrix) {
  Json rows = Json::array();
  for (int r = 0; r < 3; ++r) rows.push_back({matrix(r, 0), matrix(r, 1), matrix(r, 2)});
  return rows;
}

Json ToJson(const std::vector<Eigen::Vector2d>& points_px) {
  Json list = Json::array();
  for (const Eigen::Vector2d& p : points_px) list.push_back({Rounded(p.x(), 2), Rounded(p.y(), 2)});
  return list;
}

}  // namespace waystone
