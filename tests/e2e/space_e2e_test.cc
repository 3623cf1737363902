// SPDX-License-Identifier: Apache-2.0
// What a calibrated camera saw, in space and by direction, against the made room's truth.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>
#include <string>

#include "api/json.h"
#include "core/geometry/angle.h"
#include "schema/file/map_store.h"
#include "server/service/application.h"
#include "tests/e2e/calibrated_maps.h"
#include "tests/e2e/shared_map.h"

namespace waystone {
namespace {

class CalibratedMapsTest : public testing::Test {
 protected:
  CalibratedMapsTest()
      : app_({{"walls", MapIndex::Build(ReadMap(TheCorner().map))},
              {"turns", MapIndex::Build(ReadMap(TheTurns()))}},
             {}, {}) {}

  Json GetJson(const std::string& path) {
    HttpRequest request;
    request.method = "GET";
    request.path = "/v1/maps/" + path;
    request.header = [](const std::string&) { return std::nullopt; };
    const HttpResponse response = app_.Answer(request);
    EXPECT_EQ(response.status, 200) << path << ": " << response.body;
    return Json::parse(response.body);
  }

  Json Localize(const std::string& map, const std::filesystem::path& photo,
                const std::map<std::string, std::string>& query) {
    HttpRequest request;
    request.method = "POST";
    request.path = "/v1/maps/" + map + "/localize";
    request.query = query;
    request.header = [](const std::string& name) {
      return name == "Content-Type" ? std::optional<std::string>("image/jpeg") : std::nullopt;
    };
    request.read_body = [&photo] { return ReadFile(photo); };
    const HttpResponse response = app_.Answer(request);
    EXPECT_EQ(response.status, 200) << response.body;
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

TEST_F(CalibratedMapsTest, PlacedPlanesAreTheWalls) {
  int placed = 0;
  int keyframes_with_both = 0;
  const Json keyframes = GetJson("walls/keyframes")["keyframes"];
  for (const Json& keyframe : keyframes) {
    const Json space = GetJson("walls/keyframes/" + keyframe["id"].dump() + "/space");
    std::map<size_t, double> metres_per_unit;  // by wall
    const std::vector<Wall> walls = WallsSeenFrom(PoseOf(keyframe));
    for (const Json& plane : space["planes"]) {
      if (!plane["trouble"].is_null()) continue;
      ++placed;
      const Eigen::Vector3d normal = Vector(plane["normal"]);
      const size_t wall = normal.dot(walls[0].normal) > normal.dot(walls[1].normal) ? 0 : 1;
      EXPECT_LT(std::acos(std::min(1.0, normal.dot(walls[wall].normal))) * kDegreesPerRadian, 6)
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

// The building's axes are the room's, up to quarter turns.
TEST_F(CalibratedMapsTest, AnswersSayHowTheCameraStandsInTheBuilding) {
  constexpr double kQuarter = std::numbers::pi / 2;
  for (const int photo : {3, 7, 11}) {
    const auto image = TheCorner().images / (photo < 10 ? "00" + std::to_string(photo) + ".jpg"
                                                        : "0" + std::to_string(photo) + ".jpg");
    const Json answer = Localize("walls", image, {{"camera", "images"}});
    ASSERT_EQ(answer["verdict"], "localized") << answer;
    ASSERT_TRUE(answer.contains("building")) << answer;
    EXPECT_FALSE(answer.contains("unused")) << answer;
    const Json& building = answer["building"];
    ASSERT_TRUE(building["heading"].is_object()) << building;
    EXPECT_EQ(answer["heading"], building["heading"]);
    const Eigen::Vector3d ahead = TheCorner().poses[photo].linear() * Eigen::Vector3d::UnitZ();
    const double off = building["heading"]["rad"].get<double>() - std::atan2(ahead.y(), ahead.x());
    EXPECT_LT(std::abs(std::remainder(off, kQuarter)) * kDegreesPerRadian, 2) << building;
    const Json plain = Localize("walls", image, {});
    EXPECT_FALSE(plain.contains("building")) << "without a camera there is no rotation";
  }
}

// The rig is level, so what is upright in the building is so in its pictures; of short lines nobody
// can tell.
TEST_F(CalibratedMapsTest, UprightLinesAreUpright) {
  const Json layer = GetJson("turns/orientation");
  int upright = 0;
  for (const Json& node : layer["nodes"]) {
    const Json lines = GetJson("turns/orientation/nodes/" + node["id"].dump() + "/lines");
    EXPECT_EQ(lines["of"], "frame");
    for (const Json& line : lines["lines"]) {
      const double dx = line["points"][0][0].get<double>() - line["points"][1][0].get<double>();
      const double dy = line["points"][0][1].get<double>() - line["points"][1][1].get<double>();
      if (line["axis"] != "z" || std::hypot(dx, dy) < 20) continue;
      ++upright;
      EXPECT_LT(std::atan2(std::abs(dx), std::abs(dy)) * kDegreesPerRadian, 10)
          << node["id"] << line;
    }
  }
  EXPECT_GE(upright, 3);
}

// Around one corner to the right, from x to against y.
TEST_F(CalibratedMapsTest, TheWayBendsAtTheCorner) {
  const Json layer = GetJson("turns/orientation");
  const Json& frames = layer["frames"];
  const auto count = static_cast<double>(frames["id"].size());
  EXPECT_GT(frames["x"].back().get<double>(), 0.5 * count);
  EXPECT_LT(frames["y"].back().get<double>(), -0.2 * count);
  EXPECT_EQ(frames["x"].back().get<double>() - frames["y"].back().get<double>(), count - 1);
}

}  // namespace
}  // namespace waystone
