// SPDX-License-Identifier: Apache-2.0
// What a calibrated camera saw, in space and by direction, against the made room's truth.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <string>

#include "schema/map_store.h"
#include "server/http/application.h"
#include "server/http/json.h"
#include "tests/e2e/calibrated_maps.h"

namespace waystone {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

class CornerTest : public testing::Test {
 protected:
  CornerTest() : app_({{"corner", MapIndex::Build(ReadMap(TheCorner().map))}}, {}, {}) {}

  Json GetJson(const std::string& path) {
    HttpRequest request;
    request.method = "GET";
    request.path = "/v1/maps/corner/" + path;
    request.header = [](const std::string&) { return std::nullopt; };
    const HttpResponse response = app_.Answer(request);
    EXPECT_EQ(response.status, 200) << path << ": " << response.body;
    return Json::parse(response.body);
  }

  // The pose of a keyframe, by the name of its image.
  static Eigen::Isometry3d PoseOf(const Json& keyframe) {
    return TheCorner().poses.at(std::stoul(keyframe["source"].get<std::string>()));
  }

  Application app_;
};

Eigen::Vector3d Vector(const Json& json) {
  return {json[0].get<double>(), json[1].get<double>(), json[2].get<double>()};
}

// A wall of the room that a plane may be: its normal in the camera's frame and its distance, m.
struct Wall {
  Eigen::Vector3d normal;
  double distance_m = 0;
};

std::vector<Wall> WallsSeenFrom(const Eigen::Isometry3d& pose) {
  const Eigen::Matrix3d camera_from_world = pose.linear().transpose();
  return {{camera_from_world.col(0), TheCorner().corner.x() - pose.translation().x()},
          {camera_from_world.col(1), TheCorner().corner.y() - pose.translation().y()}};
}

TEST_F(CornerTest, PlacedPlanesAreTheWalls) {
  int placed = 0;
  int keyframes_with_both = 0;
  for (const Json& keyframe : GetJson("keyframes")["keyframes"]) {
    const Json space = GetJson("keyframes/" + keyframe["id"].dump() + "/space");
    std::map<size_t, double> metres_per_unit;  // by wall
    for (const Json& plane : space["planes"]) {
      if (!plane["trouble"].is_null()) continue;
      ++placed;
      const std::vector<Wall> walls = WallsSeenFrom(PoseOf(keyframe));
      const Eigen::Vector3d normal = Vector(plane["normal"]);
      const size_t wall = normal.dot(walls[0].normal) > normal.dot(walls[1].normal) ? 0 : 1;
      EXPECT_LT(std::acos(std::min(1.0, normal.dot(walls[wall].normal))) * kDegrees, 6)
          << keyframe["id"] << ' ' << plane["id"];
      metres_per_unit[wall] = walls[wall].distance_m / plane["distance"].get<double>();
      for (const Json& point : plane["outline"]) {
        EXPECT_NEAR(Vector(point).dot(normal), plane["distance"].get<double>(), 0.01);
      }
    }
    if (metres_per_unit.size() < 2) continue;
    ++keyframes_with_both;
    EXPECT_NEAR(metres_per_unit[0] / metres_per_unit[1], 1, 0.1) << keyframe["id"];
  }
  EXPECT_GE(placed, 4);
  EXPECT_GE(keyframes_with_both, 1);
}

// The camera is level, so what is upright in the room is so in its pictures.
TEST_F(CornerTest, UprightLinesAreUpright) {
  const Json lines = GetJson("keyframes/2/lines");
  EXPECT_EQ(lines["width"], 640);
  EXPECT_EQ(lines["of"], "picture") << "this map has no orientation layer";
  int upright = 0;
  for (const Json& line : lines["lines"]) {
    if (line["axis"] != "z") continue;
    ++upright;
    const double dx = line["points"][0][0].get<double>() - line["points"][1][0].get<double>();
    const double dy = line["points"][0][1].get<double>() - line["points"][1][1].get<double>();
    EXPECT_LT(std::atan2(std::abs(dx), std::abs(dy)) * kDegrees, 10) << line;
  }
  EXPECT_GE(upright, 3);
}

}  // namespace
}  // namespace waystone
