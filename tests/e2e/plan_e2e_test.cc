// SPDX-License-Identifier: Apache-2.0
// `waystone plan`: a drawing of the building that the map was made in, in its file and its answers.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "api/json.h"
#include "core/base/text.h"
#include "tests/e2e/calibrated_maps.h"
#include "tests/e2e/drawn_plan.h"
#include "tests/e2e/served_map.h"
#include "tests/e2e/shared_map.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

class PlanTest : public testing::Test {
 protected:
  PlanTest() {
    fs::copy_file(ThePosedHall().map, map_);
    fs::copy_file(ThePosedHall().walk / "plan.png", image_);
  }
  ~PlanTest() override { fs::remove_all(folder_); }

  RunResult Plan(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"plan", map_});
    return RunWaystone(arguments);
  }

  void PutPlan() const {
    const RunResult put = Plan({image_, "--anchor", AnchorAt(0, 0), "--anchor", AnchorAt(13, 0),
                                "--anchor", AnchorAt(13, 12)});
    ASSERT_EQ(put.code, 0) << put.err;
  }

  Json Plans() const { return Json::parse(Plan({"--json"}).out)["plans"]; }

  void ExpectRefusal(const std::vector<std::string>& arguments, int code,
                     const std::string& about) {
    const std::string before = ReadFile(map_);
    const RunResult result = Plan(arguments);
    EXPECT_EQ(result.code, code) << about << ": " << result.err;
    EXPECT_EQ(result.out, "");
    // What the program says is the last line: libpng may have said something before.
    const std::vector<std::string> lines = Words(result.err, "\n");
    EXPECT_EQ(std::ranges::count_if(
                  lines, [](const std::string& line) { return line.starts_with("waystone: "); }),
              1)
        << result.err;
    EXPECT_TRUE(!lines.empty() && lines.back().starts_with("waystone: ")) << result.err;
    EXPECT_NE(result.err.find(about), std::string::npos) << about << ": " << result.err;
    EXPECT_TRUE(ReadFile(map_) == before) << about;
  }

  const fs::path folder_ = FreshFolder();
  const fs::path map_ = folder_ / "hall.db";
  const fs::path image_ = folder_ / "plan.png";
};

TEST_F(PlanTest, IsPutListedReplacedAndRemoved) {
  EXPECT_EQ(Plan({}).out, map_.string() + ": 0 floor plans\n");
  PutPlan();
  EXPECT_EQ(Plan({}).out, map_.string() +
                              ": 1 floor plan\n  Floor plan: 540x500 px, 3 anchors, 40 px per m, "
                              "residual 0 m\n");
  EXPECT_EQ(RunWaystone({"check", map_}).code, 0);
  EXPECT_NE(RunWaystone({"info", map_}).out.find("plan      Floor plan (540x500 px)"),
            std::string::npos);
  PutPlan();
  EXPECT_EQ(Plans().size(), 1u) << "one of the same name is replaced";
  ASSERT_EQ(Plan({image_, "--name", "Attic", "--heights", "3:5.5", "--anchor", AnchorAt(1, 1),
                  "--anchor", AnchorAt(5, 5)})
                .code,
            0);
  EXPECT_EQ(Plans()[0]["name"], "Attic");
  EXPECT_EQ(Plans()[0]["heights"], Json::parse(R"({"low": 3.0, "high": 5.5})"));
  ASSERT_EQ(Plan({"--remove", "Floor plan"}).code, 0);
  EXPECT_EQ(Plans().size(), 1u);
}

// Where a photo was taken is free in the drawing, and as far from its true place as the pose is.
TEST_F(PlanTest, AnswersAreOnIt) {
  PutPlan();
  const cv::Mat drawing = cv::imread(image_.string(), cv::IMREAD_GRAYSCALE);
  std::ifstream queries(ThePosedHall().walk / "queries.csv");
  std::string line;
  int placed = 0;
  std::vector<std::string> photos{"localize", map_, "--json"};
  std::vector<Eigen::Vector2d> truths;
  for (std::getline(queries, line); std::getline(queries, line) && truths.size() < 4;) {
    const std::vector<std::string> fields = Words(line, ",");
    if (fields.size() < 5) continue;
    photos.push_back(ThePosedHall().walk / fields[0]);
    truths.push_back(PixelOf(std::stod(fields[2]), std::stod(fields[3])));
  }
  const std::vector<std::string> answers = Words(RunWaystone(photos).out, "\n");
  ASSERT_EQ(answers.size(), truths.size());
  for (size_t i = 0; i < answers.size(); ++i) {
    const Json answer = Json::parse(answers[i]);
    if (answer["verdict"] != "localized" || !answer["pose"].is_object()) continue;
    ++placed;
    const Json& plan = answer["place"]["plan"];
    ASSERT_TRUE(plan.is_object()) << answer["place"];
    EXPECT_EQ(plan["name"], "Floor plan");
    const Eigen::Vector2d px(plan["x"], plan["y"]);
    EXPECT_LT((px - truths[i]).norm(), 0.05 / 0.5 * kPlanCell) << photos[i + 3];
    EXPECT_EQ(drawing.at<uint8_t>(int(px.y()), int(px.x())), 255) << "inside of a wall";
  }
  EXPECT_GE(placed, 3);
  const RunResult said = RunWaystone({"localize", map_, photos[3]});
  EXPECT_NE(said.out.find(" of the plan Floor plan ("), std::string::npos) << said.out;
}

// Of two storeys the one at the height of the camera, 1.5 m; none where there is no pose.
TEST_F(PlanTest, AnswersNameTheStorey) {
  const std::vector<std::string> anchors{"--anchor", AnchorAt(0, 0), "--anchor", AnchorAt(13, 12)};
  const auto put = [&](const std::string& name, const std::string& heights) {
    std::vector<std::string> arguments{image_, "--name", name, "--heights", heights};
    arguments.insert(arguments.end(), anchors.begin(), anchors.end());
    ASSERT_EQ(Plan(arguments).code, 0);
  };
  put("Cellar", "-3:0");
  put("Ground", "0:2.6");
  const auto plan_of = [&](const fs::path& photo) {
    return Json::parse(RunWaystone({"localize", map_, photo, "--json"}).out)["place"];
  };
  EXPECT_EQ(plan_of(ThePosedHall().walk / "queries" / "20.jpg")["plan"]["name"], "Ground");
  ASSERT_EQ(Plan({"--remove", "Ground"}).code, 0);
  const Json place = plan_of(ThePosedHall().walk / "queries" / "20.jpg");
  EXPECT_TRUE(place.contains("plan"));
  EXPECT_EQ(place["plan"], nullptr);
}

TEST_F(PlanTest, IsAnchoredAtKeyframes) {
  const Json poses = [&] {
    const Served served({}, map_);
    auto client = served.NewClient();
    return Json::parse(Checked(client.Get("/v1/maps/hall/poses"))->body);
  }();
  const Json& keyframes = poses["keyframes"];
  std::vector<std::string> arguments{image_};
  for (const size_t i : {size_t{0}, keyframes["id"].size() / 2}) {
    const Json& at = keyframes["position"][i];
    const std::string anchor = AnchorAt(at[0], at[1]);
    arguments.insert(arguments.end(),
                     {"--anchor", anchor.substr(0, anchor.find('=')) + "=keyframe:" +
                                      std::to_string(keyframes["id"][i].get<int>())});
  }
  ASSERT_EQ(Plan(arguments).code, 0);
  EXPECT_NEAR(Plans()[0]["px_per_unit"].get<double>(), kPlanCell / 0.5, 0.1);
}

TEST_F(PlanTest, IsServed) {
  PutPlan();
  const Served served({}, map_);
  auto client = served.NewClient();
  const auto plans = client.Get("/v1/maps/hall/plan");
  ASSERT_TRUE(plans);
  const Json json = Json::parse(plans->body);
  EXPECT_EQ(json["unit"], "metres");
  const std::string path = json["plans"][0]["image"];
  const auto image = client.Get(path);
  ASSERT_TRUE(image);
  EXPECT_EQ(image->status, 200);
  EXPECT_EQ(image->get_header_value("Content-Type"), "image/png");
  EXPECT_TRUE(image->body == ReadFile(image_)) << "the bytes are those of the file";
  EXPECT_EQ(Checked(client.Get("/v1/maps/hall/plan/image"))->body.size(), image->body.size());
  EXPECT_EQ(Checked(client.Get("/v1/maps/hall/plan/image?name=Attic"))->status, 404);
  EXPECT_EQ(Json::parse(Checked(client.Get("/v1/maps/hall"))->body)["floor_plans"], 1);
  const Json row = json["plans"][0]["plan_from_frame"];
  const auto answer = client.Post(
      "/v1/maps/hall/localize", ReadFile(ThePosedHall().walk / "queries" / "20.jpg"), "image/jpeg");
  const Json said = Json::parse(answer->body);
  const double x = said["pose"]["position"][0], y = said["pose"]["position"][1];
  EXPECT_NEAR(row[0][0].get<double>() * x + row[0][1].get<double>() * y + row[0][2].get<double>(),
              said["place"]["plan"]["x"].get<double>(), 0.01);
}

// A build over the map keeps the plan where the frame is the same, and its image where it isn't.
TEST_F(PlanTest, ABuildKeepsIt) {
  PutPlan();
  const Json before = Plans();
  const fs::path& walk = ThePosedHall().walk;
  const auto build = [&](const std::string& frame) {
    return RunWaystone({"build", walk / "images", "-o", map_, "--force", "--quiet", "--to", "30",
                        "--camera", walk / "camera.yaml", "--poses", walk / "poses.csv", "--unit",
                        "metres", "--frame", frame});
  };
  const std::string frame = Json::parse(Plan({"--json"}).out)["frame"];
  const RunResult same = build(frame);
  ASSERT_EQ(same.code, 0) << same.err;
  EXPECT_EQ(Plans(), before);
  EXPECT_FALSE(fs::exists(folder_ / "hall.plan.png"));
  const RunResult other = build("elsewhere");
  ASSERT_EQ(other.code, 0) << other.err;
  EXPECT_TRUE(Plans().empty());
  EXPECT_NE(other.err.find("hall.plan.png"), std::string::npos) << other.err;
  EXPECT_TRUE(ReadFile(folder_ / "hall.plan.png") == ReadFile(image_));
}

TEST_F(PlanTest, BadInputIsRefused) {
  const std::string a = AnchorAt(0, 0), b = AnchorAt(13, 0), c = AnchorAt(13, 12);
  const auto refuse = [&](const std::vector<std::string>& anchors, int code,
                          const std::string& about, const fs::path& image) {
    std::vector<std::string> arguments{image};
    for (const std::string& anchor : anchors) {
      arguments.insert(arguments.end(), {"--anchor", anchor});
    }
    ExpectRefusal(arguments, code, about);
  };
  refuse({}, 2, "two or more points", image_);
  refuse({a}, 2, "two or more points", image_);
  refuse({a, a}, 2, "same point of the image", image_);
  refuse({a, "300,20=0,0"}, 2, "same point of the map", image_);
  refuse({a, "9000,20=1,1"}, 2, "outside of the image of 540x500 px", image_);
  refuse({a, b, AnchorAt(6, 0)}, 2, "on one line", image_);
  refuse({a, b, "520,20=13,-12"}, 2, "mirrored", image_);
  refuse({a, b, "520,20=2,12"}, 2, "drawn to scale", image_);
  refuse({a, "20=1,1"}, 2, "is not an anchor", image_);
  refuse({a, "20,20"}, 2, "is not an anchor", image_);
  refuse({a, "20,20=kitchen"}, 2, "has no position", image_);
  refuse({a, "20,20=keyframe:999999"}, 3, "no keyframe 999999", image_);
  refuse({a, "20,20=node:1"}, 2, "panoramas are not in the frame", image_);
  refuse({a, b}, 3, "No such file", folder_ / "missing.png");
  const fs::path bad = folder_ / "bad.png";
  WriteFile(bad, "P5 2 2 255\nabcd");
  refuse({a, b}, 3, "save it as PNG", bad);
  std::string cut = ReadFile(image_);
  WriteFile(bad, cut.substr(0, cut.size() / 2));
  refuse({a, b}, 3, "bad.png", bad);
  cut[cut.size() / 2] ^= 0x55;  // the header is sound, and the rest isn't
  WriteFile(bad, cut);
  refuse({a, b}, 3, "bad.png", bad);
  WriteFile(bad, WithJpegSize(ReadFile(TheMap().inside), 30'000, 30'000));
  refuse({a, b}, 3, "bad.png", bad);
  WriteFile(bad, std::string(9'000'000, 'x'));
  refuse({a, b}, 3, "9000000 bytes", bad);
  ExpectRefusal({"--anchor", a}, 2, "specify the image");
  ExpectRefusal({"--remove", "Attic"}, 3, "no floor plan named 'Attic'");
  ExpectRefusal({image_, "--anchor", a, "--anchor", b, "--remove", "Attic"}, 2, "not both");
  ExpectRefusal({image_, "--anchor", a, "--anchor", c, "--name", "a\nb"}, 2, "control character");
  ExpectRefusal({image_, "--anchor", a, "--anchor", c, "--heights", "2:1"}, 2, "not a range");
  ExpectRefusal({image_, "--anchor", a, "--anchor", c, "--heights", "nan:1"}, 2, "not a range");
  fs::copy_file(TheMap().map, map_, fs::copy_options::overwrite_existing);
  ExpectRefusal({image_, "--anchor", a, "--anchor", c}, 3, "no positions for a plan");
}

}  // namespace
}  // namespace waystone
