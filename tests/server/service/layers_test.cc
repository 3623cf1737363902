// SPDX-License-Identifier: Apache-2.0
// The appearance and the orientation layer as the application shows them, and their poses in the
// formats of other programs.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "api/json.h"
#include "api/pose_formats.h"
#include "core/base/error.h"
#include "server/service/application.h"
#include "tests/server/service/made_map.h"
#include "tests/server/service/made_picture.h"

namespace waystone {
namespace {

// Of a calibrated sequence with pictures that have lines in them.
MapData PicturedMap() {
  MapData map = MadeLayeredMap(2);
  map.sequences[0].camera = MadeCamera();
  map.keyframes[0].picture = MadePicture();
  map.orientation->nodes[1].picture = MadePicture();
  return map;
}

// Of two planes; the outline of the floor has a point close to the horizon.
MapData PosedMap() {
  MapData map = MadeMap(2);
  map.sequences[0].camera = MadeCamera();
  map.planes[1].outline = {{319.5, 489.5}, {319.5, 249.5}, {419.5, 489.5}};
  AddMadePoses(map);
  return map;
}

// The same without a camera, and with one keyframe upside down.
MapData TumblingMap() {
  MapData map = PosedMap();
  map.sequences[0].camera.reset();
  Eigen::Isometry3d pose = map.poses->keyframes[1].frame_from_camera();
  pose.linear() = pose.linear() * Eigen::DiagonalMatrix<double, 3>(-1, -1, 1);
  map.poses->keyframes[1] = MakeKeyframePose(KeyframeId{2}, pose);
  return map;
}

// The same with a floor plan.
MapData Planned(MapData map) {
  AddMadeFloorPlan(map);
  return map;
}

class LayersTest : public testing::Test {
 protected:
  LayersTest()
      : app_({{"both", MapIndex::Build(MadeLayeredMap(2))},
              {"pictured", MapIndex::Build(PicturedMap())},
              {"planes", MapIndex::Build(MadeMap(1))},
              {"posed", MapIndex::Build(PosedMap())},
              {"planned", MapIndex::Build(Planned(PosedMap()))},
              {"walked", MapIndex::Build(Planned(MadeLayeredMap(2)))},
              {"tumbling", MapIndex::Build(TumblingMap())},
              {"panoramas", MapIndex::Build(MadeLayeredMap(0))}},
             {}, {}) {}

  HttpResponse Get(const std::string& path, const std::map<std::string, std::string>& query = {}) {
    HttpRequest request;
    request.method = "GET";
    request.path = "/v1/maps/" + path;
    request.query = query;
    request.header = [](const std::string&) { return std::nullopt; };
    return app_.Answer(request);
  }

  Json GetJson(const std::string& path, const std::map<std::string, std::string>& query = {}) {
    const HttpResponse response = Get(path, query);
    EXPECT_EQ(response.status, 200) << path << ": " << response.body;
    return Json::parse(response.body);
  }

  Application app_;
};

TEST_F(LayersTest, OverviewNamesWhatThereIs) {
  EXPECT_EQ(GetJson("both/overview")["layers"], Json({"planes", "appearance", "orientation"}));
  EXPECT_EQ(GetJson("planes/overview")["layers"], Json({"planes"}));
  EXPECT_EQ(GetJson("posed/overview")["layers"], Json({"planes", "poses"}));
  EXPECT_EQ(GetJson("panoramas/overview")["layers"], Json({"appearance", "orientation"}));
}

TEST_F(LayersTest, AppearanceForDrawing) {
  const Json json = GetJson("both/appearance");
  EXPECT_EQ(json["scale"], "arbitrary");
  EXPECT_TRUE(json["metres_per_unit"].is_null());
  EXPECT_EQ(json["dropped"], 4);
  ASSERT_EQ(json["nodes"].size(), 3u);
  EXPECT_EQ(json["nodes"][2],
            Json::parse(R"({"id":3,"keyframe":null,"x":2.0,"y":2.0,"heading_rad":1.5})"));
  EXPECT_EQ(json["nodes"][1]["keyframe"], 2) << "frame 7 of sequence 1 is keyframe 2";
  ASSERT_EQ(json["edges"].size(), 3u);
  EXPECT_EQ(json["edges"][1], Json::parse(R"({"a":1,"b":3,"kind":"loop","distance":0.25})"));
  EXPECT_EQ(json["edges"][0]["kind"], "odometry");
}

TEST_F(LayersTest, AppearanceInLists) {
  const Json page = GetJson("both/appearance/nodes", {{"limit", "2"}});
  ASSERT_EQ(page["nodes"].size(), 2u);
  EXPECT_EQ(page["nodes"][0]["image"], "/v1/maps/both/appearance/nodes/1/image");
  EXPECT_EQ(page["nodes"][0]["sequence"], "kit\"chen");
  EXPECT_EQ(page["nodes"][0]["sequence_id"], 1);
  EXPECT_TRUE(page["nodes"][1]["image"].is_null());
  EXPECT_TRUE(page["nodes"][1]["time_s"].is_null());
  const Json rest = GetJson("both/appearance/nodes", {{"cursor", page["next"]}});
  ASSERT_EQ(rest["nodes"].size(), 1u);
  EXPECT_EQ(rest["nodes"][0]["source"], "pano/2 a.jpg");
  EXPECT_TRUE(rest["next"].is_null());
  EXPECT_EQ(GetJson("both/appearance/nodes/1"), page["nodes"][0]);
  const Json loops = GetJson("both/appearance/loops")["loops"];
  ASSERT_EQ(loops.size(), 1u);
  EXPECT_EQ(loops[0]["b"], 3);
  EXPECT_EQ(loops[0]["a_from_b"]["x"], 2.0);
  const Json signature = GetJson("both/appearance/nodes/2/signature");
  EXPECT_EQ(signature["magnitudes"], Json::parse("[[1.25,1.25,1.25],[1.25,1.25,1.25]]"));
  EXPECT_EQ(signature["phases"], Json::parse("[[-1.5,-1.5],[-1.5,-1.5]]"));
  EXPECT_EQ(Get("both/appearance/nodes/1/image").body, "\xFF\xD8\xFF\xD9");
  for (const char* path : {"both/appearance/nodes/2/image", "both/appearance/nodes/9/image",
                           "both/appearance/nodes/x/signature", "both/appearance/nodes/9"}) {
    EXPECT_EQ(Get(path).status, 404) << path;
  }
}

TEST_F(LayersTest, OrientationForDrawing) {
  const Json json = GetJson("both/orientation");
  EXPECT_EQ(json["step"], 2);
  ASSERT_EQ(json["nodes"].size(), 2u);
  EXPECT_EQ(json["nodes"][0],
            Json::parse(R"({"id":1,"keyframe":1,"kind":"frame","heading_rad":0.0,"corridor":1,
                            "directions":[0,0,0,0],"image":null})"));
  EXPECT_EQ(json["nodes"][1]["kind"], "turn");
  EXPECT_EQ(json["nodes"][1]["directions"], Json({1, 2, 3, 4}));
  EXPECT_EQ(json["nodes"][1]["image"], "/v1/maps/both/orientation/nodes/3/image");
  EXPECT_NEAR(json["nodes"][1]["heading_rad"].get<double>(), 1.5708, 1e-4);
  EXPECT_EQ(json["edges"], Json::parse(R"([{"a":1,"b":3,"kind":"traversable","matches":31}])"));
  EXPECT_EQ(json["corridors"][1],
            Json::parse(R"({"id":2,"axis":"y","first":3,"last":4,"nodes":[3]})"));
  EXPECT_EQ(json["turns"], GetJson("both/orientation/turns")["turns"]);
}

// A turn to the left at frame 3, which the last frame follows.
TEST_F(LayersTest, OrientationFramesByColumns) {
  const Json frames = GetJson("both/orientation")["frames"];
  EXPECT_EQ(frames["id"], Json({1, 2, 3, 4}));
  EXPECT_EQ(frames["sequence"], Json({1, 1, 1, 1}));
  EXPECT_EQ(frames["frame"], Json({0, 1, 2, 3}));
  EXPECT_EQ(frames["x"], Json({0.0, 1.0, 2.0, 2.0}));
  EXPECT_EQ(frames["y"], Json({0.0, 0.0, 0.0, 1.0}));
  EXPECT_EQ(frames["heading_rad"], Json({0.0, 0.0, 1.5708, nullptr}));
  EXPECT_EQ(frames["reliable"], Json({true, true, true, false}));
  EXPECT_EQ(frames["lines_y"], Json({20, 20, 20, 20}));
}

TEST_F(LayersTest, PosesForDrawing) {
  const Json json = GetJson("posed/poses");
  EXPECT_EQ(json["frame"], "hall");
  EXPECT_EQ(json["unit"], "metres");
  EXPECT_EQ(json["noise"],
            Json::parse(R"({"position_deviation":0.01,"rotation_deviation_rad":null})"));
  EXPECT_EQ(json["up"], Json({0.0, 0.0, 1.0}));
  EXPECT_EQ(json["keyframes"]["id"], Json({1, 2}));
  EXPECT_EQ(json["keyframes"]["position"], Json::parse("[[1.0,2.0,1.5],[2.0,2.0,1.5]]"));
  EXPECT_EQ(json["keyframes"]["orientation"][1], Json({-0.5, 0.5, -0.5, 0.5}));
}

// The wall is 4 m ahead of its reference keyframe, whose camera has a focal length of 500 px.
TEST_F(LayersTest, PosedPlanesHaveTheirOutlineInTheFrame) {
  const Json planes = GetJson("posed/poses")["planes"];
  ASSERT_EQ(planes.size(), 2u);
  EXPECT_EQ(planes[0], Json::parse(R"({"id":1,"reference":1,"normal":[1.0,0.0,0.0],"distance":5.0,
      "outline":[[5.0,4.556,3.416],[5.0,3.755016,3.416],[5.0,3.756,3.012]]})"));
  EXPECT_EQ(planes[1]["outline"], Json::parse("[[4.0,2.0,0.0],[4.0,1.4,0.0]]"))
      << "but for the point near the horizon";
}

TEST_F(LayersTest, PosesThatSayNothingOfUpOrOutlines) {
  const Json json = GetJson("tumbling/poses");
  EXPECT_TRUE(json["up"].is_null()) << "one keyframe is upside down";
  ASSERT_EQ(json["planes"].size(), 2u);
  EXPECT_EQ(json["planes"][0]["outline"], Json::array()) << "no camera";
}

// How many lines run along an axis.
int64_t Along(const Json& lines, const Json& axis) {
  return std::ranges::count_if(lines["lines"],
                               [&](const Json& line) { return line["axis"] == axis; });
}

TEST_F(LayersTest, LinesOfAKeyframeInItsOwnPixels) {
  const Json lines = GetJson("pictured/keyframes/1/lines");
  EXPECT_EQ(lines["width"], 640);
  EXPECT_EQ(lines["height"], 480);
  EXPECT_EQ(lines["of"], "frame") << "frame 0 looks along the building's x";
  EXPECT_TRUE(lines["reliable"].get<bool>());
  for (const char* axis : {"x", "y", "z"}) EXPECT_GE(Along(lines, axis), 4) << axis;
  double right = 0;
  for (const Json& line : lines["lines"]) {
    for (const Json& point : line["points"]) right = std::max(right, point[0].get<double>());
  }
  EXPECT_NEAR(right, 2 * 310, 6);
}

TEST_F(LayersTest, LinesOfANodeInItsPicturesPixels) {
  const Json lines = GetJson("pictured/orientation/nodes/3/lines");
  EXPECT_EQ(lines["width"], 320);
  EXPECT_EQ(lines["of"], "frame") << "frame 2 looks along y";
  const Json ahead = *std::ranges::find_if(lines["lines"], [](const Json& line) {
    return line["points"][0][0].get<double>() < 100 && line["points"][1][1].get<double>() < 100;
  });
  EXPECT_EQ(ahead["axis"], "y");
  EXPECT_EQ(GetJson("pictured/orientation/frames/3")["frame"], 2);
}

// Five features a plane are too few to say anything.
TEST_F(LayersTest, PlanesInSpaceThatNothingTellsHaveTheirError) {
  const Json space = GetJson("pictured/keyframes/1/space");
  EXPECT_EQ(space["keyframe"], 1);
  EXPECT_TRUE(space["unit_plane"].is_null());
  EXPECT_EQ(space["corners"][0], Json::parse("[-0.639,-0.479,1.0]"));
  ASSERT_EQ(space["planes"].size(), 2u);
  EXPECT_EQ(space["planes"][1],
            Json::parse(R"({"id":2,"trouble":"no_parallax","normal":null,"distance":null,
                            "normal_deviation_rad":null,"distance_deviation":null,"outline":[]})"));
}

TEST_F(LayersTest, LinesThatCantBeGivenAreSaid) {
  for (const auto& [path, status] :
       std::map<std::string, int>{{"planes/keyframes/1/lines", 422},
                                  {"planes/keyframes/1/space", 422},            // no camera
                                  {"pictured/keyframes/2/lines", 404},          // no picture
                                  {"pictured/orientation/nodes/1/lines", 404},  // no picture
                                  {"pictured/orientation/nodes/9/lines", 404},  // no node
                                  {"pictured/orientation/frames/9", 404},
                                  {"planes/orientation/frames/1", 404}}) {
    EXPECT_EQ(Get(path).status, status) << path;
  }
}

TEST_F(LayersTest, OrientationInLists) {
  const Json frames = GetJson("both/orientation/frames")["frames"];
  ASSERT_EQ(frames.size(), 4u);
  EXPECT_EQ(frames[2]["deviation_rad"], 0.02);
  EXPECT_EQ(frames[2]["lines"], Json({10, 20, 30}));
  EXPECT_NEAR(frames[2]["building_from_head"][1][2].get<double>(), 1, 1e-9);
  EXPECT_FALSE(frames[3]["reliable"].get<bool>());
  EXPECT_TRUE(frames[3]["heading_rad"].is_null());
  EXPECT_TRUE(frames[3]["building_from_head"].is_null());
  EXPECT_EQ(
      GetJson("both/orientation/turns")["turns"],
      Json::parse(
          R"([{"frame":3,"direction":"left","angle_rad":1.5,"confirmed":true,"axis_after":"y"}])"));
  EXPECT_EQ(GetJson("both/orientation/corridors", {{"limit", "1"}})["corridors"][0]["axis"], "x");
  EXPECT_EQ(Get("both/orientation/nodes/3/image").status, 200);
  EXPECT_EQ(Get("both/orientation/nodes/1/image").status, 404);
}

TEST_F(LayersTest, FloorPlansWithTheirTransform) {
  const Json posed = GetJson("planned/plan");
  EXPECT_EQ(posed["frame"], "hall");
  EXPECT_EQ(posed["unit"], "metres");
  EXPECT_EQ(posed["right"], Json::parse("[1.0, 0.0, 0.0]"));
  const Json& plan = posed["plans"][0];
  EXPECT_EQ(plan["image"], "/v1/maps/planned/plan/image?name=Ground%20floor");
  EXPECT_EQ(plan["heights"], Json::parse(R"({"low": -1.0, "high": 2.6})"));
  const double expected[2][3] = {{10, 0, 0}, {0, -10, 60}};
  for (int row = 0; row < 2; ++row) {
    for (int column = 0; column < 3; ++column) {
      EXPECT_NEAR(plan["plan_from_frame"][row][column].get<double>(), expected[row][column], 1e-9);
    }
  }
  EXPECT_NEAR(plan["px_per_unit"].get<double>(), 10, 1e-9);
  const Json walked = GetJson("walked/plan");
  EXPECT_EQ(walked["frame"], "layer");
  EXPECT_FALSE(walked.contains("unit"));
  EXPECT_EQ(walked["plans"][0]["heights"], nullptr);
  EXPECT_TRUE(GetJson("planes/plan")["plans"].empty());
  EXPECT_EQ(GetJson("planned")["floor_plans"], 1);
  for (const std::map<std::string, std::string>& query :
       {std::map<std::string, std::string>{}, {{"name", "Ground floor"}}}) {
    const HttpResponse image = Get("planned/plan/image", query);
    EXPECT_EQ(image.status, 200);
    EXPECT_EQ(image.content_type, "image/jpeg");
    EXPECT_EQ(image.body.substr(0, 2), "\xFF\xD8");
  }
  EXPECT_EQ(Get("planned/plan/image", {{"name", "Attic"}}).status, 404);
  EXPECT_EQ(Get("planes/plan/image").status, 404);
}

TEST_F(LayersTest, WithoutTheLayerThereIsNothing) {
  for (const char* path :
       {"planes/appearance", "planes/appearance/nodes", "planes/appearance/loops",
        "planes/appearance/nodes/1/signature", "planes/orientation", "planes/orientation/frames",
        "planes/orientation/turns", "planes/orientation/corridors", "planes/poses"}) {
    const HttpResponse response = Get(path);
    EXPECT_EQ(response.status, 404) << path;
    const Json json = Json::parse(response.body);
    EXPECT_EQ(json["code"], "no_layer") << path;
    EXPECT_NE(json["detail"].get<std::string>().find("build it from"), std::string::npos);
  }
}

std::string Text(const MapData& map, const std::string& format) {
  return FormatPoses(map, format).value().text;
}

std::vector<std::string> LinesOf(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

// The numbers behind a line's first word.
std::vector<double> NumbersOf(const std::string& line) {
  std::istringstream in(line);
  std::string word;
  in >> word;
  std::vector<double> numbers;
  for (double number = 0; in >> number;) numbers.push_back(number);
  return numbers;
}

TEST(PoseFormats, G2oIsTheGraph) {
  const std::vector<std::string> lines = LinesOf(Text(MadeLayeredMap(0, 0.5), "g2o"));
  ASSERT_EQ(lines.size(), 1u + 3 + 3);
  EXPECT_NE(lines[0].find("metres"), std::string::npos);
  EXPECT_EQ(lines[3], "VERTEX_SE2 3 1 1 1.5");
  // 2 units are 1 m: a sigma of half a metre; 0.02 rad for the heading.
  EXPECT_EQ(lines[4], "EDGE_SE2 1 2 1 0 0 4 0 0 4 0 2500");
}

TEST(PoseFormats, PlyHasNodesAndEdges) {
  const std::string text = Text(MadeLayeredMap(0), "ply");
  EXPECT_TRUE(text.starts_with("ply\nformat ascii 1.0\n"));
  EXPECT_NE(text.find("unknown scale"), std::string::npos);
  EXPECT_NE(text.find("element vertex 3\n"), std::string::npos);
  EXPECT_NE(text.find("end_header\n0 0 0 1\n2 0 0 2\n2 2 0 3\n0 1 0\n0 2 1\n1 2 0\n"),
            std::string::npos)
      << text;
}

TEST(PoseFormats, GeoJsonSaysWhoseFrameItIs) {
  const Json json = Json::parse(Text(MadeLayeredMap(0), "geojson"));
  EXPECT_EQ(json["frame"]["unit"], "unit");
  ASSERT_EQ(json["features"].size(), 6u);
  EXPECT_EQ(json["features"][2]["geometry"]["coordinates"], Json({2.0, 2.0}));
  EXPECT_EQ(json["features"][4]["geometry"]["coordinates"], Json::parse("[[0.0,0.0],[2.0,2.0]]"));
  EXPECT_EQ(json["features"][4]["properties"]["kind"], "loop");
}

TEST(PoseFormats, TumCountsFramesWhereATimeIsMissing) {
  MapData map = MadeLayeredMap(0);
  std::vector<std::string> lines = LinesOf(Text(map, "tum"));
  ASSERT_EQ(lines.size(), 2u + 3);
  EXPECT_NE(lines[0].find("frame number"), std::string::npos);
  EXPECT_TRUE(lines[4].starts_with(
      "14.000000 2.000000 2.000000 0.000000 0.000000000 0.000000000 0.681638760 0.731688869"))
      << lines[4];
  map.appearance->nodes[1].time_s = 0.75;
  lines = LinesOf(Text(map, "tum"));
  EXPECT_TRUE(lines[0].starts_with("# time_s"));
  EXPECT_TRUE(lines[3].starts_with("0.750000 "));
}

// The camera's centre is -R^T t, and the node looks along its heading.
TEST(PoseFormats, ResultLinesAreCameraFromWorld) {
  EXPECT_THROW(FormatPoses(MadeLayeredMap(0), "poses"), MapError) << "no scale, no metres";
  const std::vector<std::string> lines = LinesOf(Text(MadeLayeredMap(0, 0.5), "poses"));
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_TRUE(lines[2].starts_with("pano/2_a.jpg "));
  const std::vector<double> n = NumbersOf(lines[2]);
  ASSERT_EQ(n.size(), 7u);
  const Eigen::Quaterniond q(n[0], n[1], n[2], n[3]);
  EXPECT_NEAR(q.norm(), 1, 1e-6);
  const Eigen::Vector3d centre = -(q.conjugate() * Eigen::Vector3d(n[4], n[5], n[6]));
  EXPECT_LT((centre - Eigen::Vector3d(1, 1, 0)).norm(), 1e-6) << centre.transpose();
  const Eigen::Vector3d ahead = q.conjugate() * Eigen::Vector3d::UnitZ();
  EXPECT_LT((ahead - Eigen::Vector3d(std::cos(1.5), std::sin(1.5), 0)).norm(), 1e-6);
  const Eigen::Vector3d down = q.conjugate() * Eigen::Vector3d::UnitY();
  EXPECT_NEAR(down.z(), -1, 1e-6);
}

TEST(PoseFormats, WhatAMapCantGiveIsSaid) {
  for (const std::string& format : PoseFormatNames()) {
    EXPECT_THROW(FormatPoses(MadeMap(1), format), MapError) << format;
  }
  EXPECT_FALSE(FormatPoses(MadeMap(1), "svg").has_value());
}

}  // namespace
}  // namespace waystone
