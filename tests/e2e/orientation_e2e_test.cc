// SPDX-License-Identifier: Apache-2.0
// The orientation layer as a user makes and asks it.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "api/json.h"
#include "tests/e2e/shared_map.h"
#include "world/render.h"
#include "world/rig.h"
#include "world/walk.h"
#include "world/world.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCorridor = R"(
############
#..........#
#..........#
#..........#
############
)";

// Six steps of a six-camera rig along a corridor, one folder a moment; made once.
const fs::path& RigFolder() {
  static const fs::path folder = [] {
    fs::path made = TheMap().folder / "rig";
    WorldOptions look;
    look.texel_m = 0.02;
    look.texture_richness = 0.3;
    const World world(ParseFloorPlan(kCorridor), look);
    for (int step = 0; step < 6; ++step) {
      const Eigen::Isometry3d head = WorldFromCamera({1.2 + 0.15 * step, 1.2, 1.4}, 0.1);
      const fs::path moment = made / ("00" + std::to_string(step));
      fs::create_directories(moment);
      for (const RigFace& face : SixFaceRig(160)) {
        Eigen::Isometry3d pose = head;
        pose.linear() = head.linear() * face.rig_from_camera;
        cv::imwrite((moment / (std::string(face.name) + ".png")).string(),
                    Renderer(face.camera).Render(world, pose).grey);
      }
    }
    return made;
  }();
  return folder;
}

TEST(OrientationCommands, DirectionsOfARigAreTheCorridors) {
  const RunResult result = RunWaystone({"directions", RigFolder(), "--json"});
  ASSERT_EQ(result.code, 0) << result.err;
  std::istringstream lines(result.out);
  std::string line;
  int photos = 0;
  for (; std::getline(lines, line); ++photos) {
    const Json json = Json::parse(line);
    ASSERT_TRUE(json["reliable"].get<bool>()) << line;
    // The head looks 0.1 to the left of the corridor, which is therefore to its right.
    const Json ahead = json["axes"][2];
    EXPECT_NEAR(std::atan2(ahead[0].get<double>(), ahead[2].get<double>()), 0.1, 0.02) << line;
  }
  EXPECT_EQ(photos, 6);
}

// How many pixels are clearly of a colour, blue, green or red.
int Coloured(const cv::Mat& picture, int channel) {
  int count = 0;
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      const auto& pixel = picture.at<cv::Vec3b>(y, x);
      const int others = std::max(pixel[(channel + 1) % 3], pixel[(channel + 2) % 3]);
      count += pixel[channel] > others + 80 ? 1 : 0;
    }
  }
  return count;
}

TEST(OrientationCommands, DirectionsDrawsLinesInTheColoursOfTheirAxes) {
  const fs::path folder = FreshFolder();
  const RunResult result = RunWaystone({"directions", RigFolder(), "--draw", folder / "drawn"});
  ASSERT_EQ(result.code, 0) << result.err;
  const cv::Mat picture = cv::imread((folder / "drawn" / "000_lines.png").string());
  ASSERT_EQ(picture.size(), cv::Size(3 * 480, 2 * 480)) << "six cameras in two rows";
  for (const int channel : {0, 1, 2}) EXPECT_GT(Coloured(picture, channel), 500) << channel;
  fs::remove_all(folder);
  const RunResult unwritable = RunWaystone({"directions", RigFolder(), "--draw", "/proc/drawn"});
  EXPECT_NE(unwritable.code, 0);
  EXPECT_NE(unwritable.err.find("can't be written"), std::string::npos) << unwritable.err;
}

TEST(OrientationCommands, BuildMakesTheLayerAndInfoCountsIt) {
  const fs::path map = TheMap().folder / "rig.db";
  const RunResult built = RunWaystone(
      {"build", RigFolder(), "-o", map, "--layers", "orientation", "--json", "--force"});
  ASSERT_EQ(built.code, 0) << built.err;
  EXPECT_NE(built.err.find("calibrated (orientation layer)"), std::string::npos) << built.err;
  const Json summary = Json::parse(built.out);
  EXPECT_EQ(summary["orientation"]["frames"], 6);
  EXPECT_EQ(summary["orientation"]["report"]["unreadable"], 0);
  const RunResult info = RunWaystone({"info", map, "--json"});
  ASSERT_EQ(info.code, 0) << info.err;
  EXPECT_EQ(Json::parse(info.out)["orientation"]["frames"], 6);
  EXPECT_GE(Json::parse(info.out)["orientation"]["reliable"], 1);
  const RunResult text = RunWaystone({"info", map});
  EXPECT_NE(text.out.find("6 orientation frames with 0 turns"), std::string::npos) << text.out;
  EXPECT_EQ(RunWaystone({"check", map}).code, 0);
}

TEST(OrientationCommands, BuildSaysWhatTheLayerTakes) {
  const RunResult result = RunWaystone(
      {"build", TheMap().images, "-o", TheMap().folder / "none.db", "--layers", "orientation"});
  EXPECT_EQ(result.code, 3);
  EXPECT_NE(result.err.find("use --camera"), std::string::npos) << result.err;
  EXPECT_FALSE(fs::exists(TheMap().folder / "none.db"));
}

}  // namespace
}  // namespace waystone
