// SPDX-License-Identifier: Apache-2.0
// `waystone eval` and `waystone audit` as a user runs them.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "api/json.h"
#include "tests/e2e/shared_map.h"
#include "world/render.h"
#include "world/rig.h"
#include "world/walk.h"
#include "world/world.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

class EvalTest : public testing::Test {
 protected:
  ~EvalTest() override { fs::remove_all(folder_); }

  fs::path Csv(const std::string& text) const {
    WriteFile(folder_ / "queries.csv", text);
    return folder_ / "queries.csv";
  }

  static void ExpectFailure(const RunResult& result, int code, const std::string& about) {
    EXPECT_EQ(result.code, code) << result.err;
    EXPECT_EQ(result.out, "");
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_TRUE(result.err.starts_with("waystone: ")) << result.err;
    EXPECT_NE(result.err.find(about), std::string::npos) << result.err;
  }

  // A bad line, of which the message must say where it is and what is wrong with it.
  void ExpectBadLine(const std::string& text, int line, const std::string& about) const {
    const RunResult result = RunWaystone({"eval", TheMap().map, Csv(text)});
    ExpectFailure(result, 3, about);
    EXPECT_NE(result.err.find("queries.csv, line " + std::to_string(line) + ": "),
              std::string::npos)
        << result.err;
  }

  const fs::path folder_ = FreshFolder();
};

// The photo's frame is known; the pictures of the walk are queries about themselves.
TEST_F(EvalTest, CountsWhatIsInTheMapAndWhatIsNot) {
  const std::string images = TheMap().images.string();
  const fs::path csv =
      Csv("image,frame\n" + TheMap().inside.string() + ",20\n" + images + "/10.jpg,10\n" + images +
          "/30.jpg,30\n" + TheMap().elsewhere.string() + ",\n");
  fs::create_directories(folder_ / "negatives" / "deeper");
  fs::copy_file(TheMap().elsewhere, folder_ / "negatives" / "1.jpg");
  fs::copy_file(TheMap().elsewhere, folder_ / "negatives" / "deeper" / "2.JPG");
  WriteFile(folder_ / "negatives" / "notes.txt", "no image");
  const RunResult run = RunWaystone(
      {"eval", TheMap().map, csv, "--negatives", folder_ / "negatives", "--json", "--quiet"});
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(run.err, "");
  const Json json = Json::parse(run.out);
  EXPECT_EQ(json["map"], "room");
  EXPECT_EQ(json["positives"], 3);
  EXPECT_EQ(json["negatives"], 3);
  EXPECT_EQ(json["right"], 3) << run.out;
  EXPECT_EQ(json["false_accepts"], 0);
  EXPECT_EQ(json["recall"], 1.0);
  EXPECT_EQ(json["recall_at_full_precision"], 1.0);
  EXPECT_TRUE(json["threshold"].is_null());
  ASSERT_EQ(json["reliability"].size(), 10u);
  int answers = 0;
  for (const Json& bin : json["reliability"]) answers += bin["count"].get<int>();
  EXPECT_EQ(answers, 6);
  EXPECT_GT(json["latency_ms"]["total"]["p50"].get<double>(),
            json["latency_ms"]["extract"]["p50"].get<double>());
  EXPECT_TRUE(json["position_m"].is_null());
  EXPECT_TRUE(json["within"].empty());
  EXPECT_TRUE(json["failures"].empty());
}

TEST_F(EvalTest, WrongLabelsAreMistakesThatAreListed) {
  const fs::path csv = Csv("image,frame\n" + TheMap().inside.string() + ",\n" +
                           TheMap().elsewhere.string() + ",5\n");
  const RunResult json_run = RunWaystone({"eval", TheMap().map, csv, "--json", "--quiet"});
  ASSERT_EQ(json_run.code, 0) << json_run.err;
  const Json json = Json::parse(json_run.out);
  EXPECT_EQ(json["false_accepts"], 1);
  EXPECT_EQ(json["recall"], 0.0);
  ASSERT_EQ(json["failures"].size(), 2u);
  EXPECT_EQ(json["failures"][0]["outcome"], "false_accept");
  EXPECT_EQ(json["failures"][1]["outcome"], "missed");
  const RunResult table = RunWaystone({"eval", TheMap().map, csv, "--quiet"});
  EXPECT_EQ(table.code, 0);
  EXPECT_NE(table.out.find("false answers\n"), std::string::npos) << table.out;
  EXPECT_NE(table.out.find("latency (ms)"), std::string::npos);
}

TEST_F(EvalTest, PositionsGiveTheTrajectorysError) {
  std::string poses = "frame,x,y,z\n";
  for (int i = 0; i < 200; ++i) poses += std::to_string(i) + "," + std::to_string(i) + ",0,0\n";
  WriteFile(folder_ / "poses.csv", poses);
  const fs::path csv = Csv("image,frame,x,y,z\n" + TheMap().inside.string() + ",20,20.5,3,0\n");
  const RunResult run = RunWaystone(
      {"eval", TheMap().map, csv, "--poses", folder_ / "poses.csv", "--json", "--quiet"});
  ASSERT_EQ(run.code, 0) << run.err;
  const Json position = Json::parse(run.out)["position_m"];
  ASSERT_TRUE(position.is_object()) << run.out;
  EXPECT_EQ(position["count"], 1);
  EXPECT_GE(position["rmse"].get<double>(), 3.0);
  EXPECT_LE(position["rmse"].get<double>(), 15.0);
  EXPECT_EQ(Json::parse(run.out)["within"].size(), 4u);
}

// The pictures of the walk under names with text and without orientations, 0.1 m apart.
TEST_F(EvalTest, ImagesHaveThePosesOfTheNumbersInTheirNames) {
  std::string poses = "frame,x,y,z\n";
  for (int i = 0; i < 200; ++i) {
    poses += std::to_string(i) + "," + std::to_string(0.1 * i) + ",0,0\n";
  }
  WriteFile(folder_ / "poses.csv", poses);
  fs::create_directories(folder_ / "photos");
  fs::copy_file(TheMap().images / "0.jpg", folder_ / "photos/IMG_0000.jpg");
  fs::copy_file(TheMap().images / "30.jpg", folder_ / "photos/IMG_0030.jpg");
  const auto run = [&](const std::string& format) {
    return RunWaystone({"eval", TheMap().map, folder_ / "photos", "--truth", folder_ / "poses.csv",
                        "--quiet", format});
  };
  const Json json = Json::parse(run("--json").out);
  EXPECT_EQ(json["right"], 2) << json;
  EXPECT_LT(json["position_m"]["max"].get<double>(), 1.5) << "those of frames 0 and 1 are far off";
  EXPECT_TRUE(json["within"][3]["pose"].is_null()) << json["within"];
  fs::rename(folder_ / "photos/IMG_0030.jpg", folder_ / "photos/v2_0030.jpg");
  ExpectFailure(run("--json"), 3, "v2_0030.jpg has no pose in the file of --truth");
}

TEST_F(EvalTest, KeyframesByName) {
  const Json info = Json::parse(RunWaystone({"audit", TheMap().map, "--json"}).out);
  EXPECT_EQ(info["map"], "room");
  const std::string photo = TheMap().inside.string();
  for (const char* name : {"0.jpg", "images:0.jpg", "images:0.jpg|0.jpg"}) {
    const RunResult run =
        RunWaystone({"eval", TheMap().map, Csv("image,keyframe\n" + photo + "," + name + "\n")});
    EXPECT_EQ(run.code, 0) << run.err;
    EXPECT_NE(run.out.find("1 in the map, 0 not"), std::string::npos) << run.out;
  }
}

TEST_F(EvalTest, BadLinesAreNamed) {
  const std::string photo = TheMap().inside.string();
  ExpectBadLine("image,keyframe\n" + photo + ",nowhere.jpg\n", 2, "nowhere.jpg");
  ExpectBadLine("image,keyframe\n\n" + photo + "\n", 3, "1 field");
  ExpectBadLine("image,keyframe\n# a comment\nmissing.jpg,\n", 3, "missing.jpg");
  ExpectBadLine("image,frame\n" + photo + ",often\n", 2, "often");
  ExpectBadLine("image,frame\n" + photo + ",attic:3\n", 2, "attic");
  ExpectBadLine("image,frame\n" + photo + ",|\n", 2, "\"|\" names no keyframe or frame");
  ExpectBadLine("image,frame\n" + photo + ",20\n" + photo + ",500000\n", 3, "frame 500000");
  ExpectBadLine("image,frame\n" + photo + ",20|images:500000\n", 2, "frame images:500000");
  ExpectBadLine("image,frame,frame\n" + photo + ",3,5\n", 1, "two columns \"frame\"");
  ExpectBadLine("image,frame,x,y,z\n" + photo + ",3,1,2,here\n", 2, "here");
  ExpectBadLine("image,frame,x,y\n" + photo + ",3,1,2\n", 1, "x, y and z");
  ExpectBadLine("picture,frame\n" + photo + ",3\n", 1, "image");
  ExpectBadLine("image\n" + photo + "\n", 1, "keyframe");
  ExpectBadLine("image,frame\n,3\n", 2, "image field is empty");
  ExpectBadLine("image,frame\n", 1, "no queries");
  ExpectBadLine("", 1, "missing header");
}

// As spreadsheets write it.
TEST_F(EvalTest, AByteOrderMarkIsNoPartOfAName) {
  const RunResult run =
      RunWaystone({"eval", TheMap().map,
                   Csv("\xef\xbb\xbfimage,frame\r\n" + TheMap().inside.string() + ",20\r\n")});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_NE(run.out.find("1 in the map, 0 not"), std::string::npos) << run.out;
}

// The last frames of the walk need not be keyframes.
TEST_F(EvalTest, AllFramesOfTheSequenceAreValid) {
  const int frames = static_cast<int>(std::distance(fs::directory_iterator(TheMap().images), {}));
  std::string text = "image,frame\n";
  for (const int frame : {0, frames / 2, frames - 1}) {
    text += TheMap().elsewhere.string() + "," + std::to_string(frame) + "\n";
  }
  const RunResult run = RunWaystone({"eval", TheMap().map, Csv(text)});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_NE(run.out.find("3 in the map, 0 not"), std::string::npos) << run.out;
}

TEST_F(EvalTest, FilesThatAreNone) {
  ExpectFailure(RunWaystone({"eval", TheMap().map, folder_ / "none.csv"}), 3, "none.csv");
  ExpectFailure(RunWaystone({"eval", TheMap().map, "--negatives", folder_ / "none"}), 3, "none");
  ExpectFailure(RunWaystone({"eval", TheMap().map, "--negatives", folder_}), 3, "no image");
  ExpectFailure(RunWaystone({"eval", TheMap().map}), 2, "--negatives");
  ExpectFailure(RunWaystone({"audit", folder_ / "none.db"}), 3, "none.db");
}

// Two rooms with the same poster each, and nothing else in common.
const char* const kTwoRooms = R"(
#####a############a#####
#..........##..........#
#..........##..........#
#..........##..........#
#..........##..........#
#..........##..........#
########################
)";

void WriteRoom(const World& world, double from, double to, const fs::path& folder) {
  WalkOptions options;
  options.step_m = 0.12;
  options.gaze_rad = 0.2;
  options.gaze_offset_rad = std::numbers::pi / 2;
  const Walk walk = WalkThrough(world.plan(), {{from, 4.0}, {to, 4.0}}, options);
  fs::create_directories(folder);
  const Camera camera = PinholeCamera(640, 480, 1.1);
  for (size_t i = 0; i < walk.frames.size(); ++i) {
    RenderOptions look;
    look.noise_sigma = 2.0;
    look.noise_seed = 1000 * static_cast<uint64_t>(from) + i;
    cv::imwrite((folder / (std::to_string(i) + ".jpg")).string(),
                Render(world, camera, walk.frames[i].world_from_camera, look).grey);
  }
}

// The audit of a map of both rooms, in which the poster is this large.
Json AuditOfRooms(const fs::path& folder, double poster_m) {
  WorldOptions options;
  options.poster_probability = 0;
  options.poster_width_m = poster_m;
  options.poster_height_m = 1.2 * poster_m;
  const World world(ParseFloorPlan(kTwoRooms), options);
  WriteRoom(world, 3.5, 8.0, folder / "west");
  WriteRoom(world, 16.0, 20.5, folder / "east");
  const fs::path map = folder / "rooms.db";
  const RunResult build =
      RunWaystone({"build", folder / "west", folder / "east", "-o", map, "--quiet"});
  EXPECT_EQ(build.code, 0) << build.err;
  const RunResult text = RunWaystone({"audit", map});
  EXPECT_NE(text.out.find("west:"), std::string::npos) << text.out;
  return Json::parse(RunWaystone({"audit", map, "--json"}).out);
}

TEST_F(EvalTest, RepeatedPosterIsAnAlias) {
  const Json json = AuditOfRooms(folder_, 0.5);
  ASSERT_GE(json["aliases"].size(), 1u) << json.dump();
  const Json& alias = json["aliases"][0];
  EXPECT_EQ(alias["a"]["sequence"], "west");
  EXPECT_EQ(alias["b"]["sequence"], "east");
  EXPECT_GE(alias["inliers"].get<int>(), 15);
  EXPECT_NE(alias["advice"], "");
}

TEST_F(EvalTest, PlainRoomHasNoAlias) {
  const Json plain = Json::parse(RunWaystone({"audit", TheMap().map, "--json"}).out);
  EXPECT_TRUE(plain["aliases"].empty()) << plain.dump();
  EXPECT_TRUE(plain["ties"].empty()) << plain.dump();
}

TEST_F(EvalTest, TimeStampsAreAssociatedWithinTheGivenDifference) {
  std::string estimate, truth;
  for (int i = 0; i < 5; ++i) {
    const std::string position = std::to_string(i * i) + " " + std::to_string(i) + " 0 0 0 0 1\n";
    estimate += std::to_string(i) + ".004 " + position;
    truth += std::to_string(i) + ".0 " + position;
  }
  WriteFile(folder_ / "estimate", estimate);
  WriteFile(folder_ / "truth", truth);
  const auto code = [this](const std::string& difference) {
    return RunWaystone({"eval", "trajectory", folder_ / "estimate", folder_ / "truth",
                        "--max-difference", difference})
        .code;
  };
  EXPECT_EQ(code("0.005"), 0);
  EXPECT_EQ(code("0.003"), 3);
}

}  // namespace
}  // namespace waystone
