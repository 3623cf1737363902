// SPDX-License-Identifier: Apache-2.0
// The commands on panoramas as a user runs them.
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "server/http/json.h"
#include "tests/e2e/shared_map.h"
#include "world/render.h"
#include "world/rig.h"
#include "world/walk.h"
#include "world/world.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

class PanoramaCommands : public testing::Test {
 protected:
  ~PanoramaCommands() override { fs::remove_all(folder_); }

  // Writes a panorama with this yaw.
  fs::path Write(const std::string& name, double yaw_rad) const {
    static const World world = [] {
      WorldOptions options;
      options.texel_m = 0.02;
      return World(DemoPlan(), options);
    }();
    const Renderer renderer(PanoramaCamera(256));
    const fs::path path = folder_ / name;
    cv::imwrite(path.string(),
                renderer.Render(world, WorldFromCamera({6.5, 10.5, 1.5}, yaw_rad)).grey);
    return path;
  }

  const fs::path folder_ = FreshFolder();
};

TEST_F(PanoramaCommands, CompassSaysHowPanoramasAreTurned) {
  const fs::path a = Write("a.png", 0.1);
  const fs::path b = Write("b.png", 0.6);
  const RunResult result = RunWaystone({"compass", a, b, a, "--json"});
  ASSERT_EQ(result.code, 0) << result.err;
  std::istringstream lines(result.out);
  std::string line;
  std::getline(lines, line);
  const Json json = Json::parse(line);
  EXPECT_NEAR(json["heading_deg"].get<double>(), 0.5 * 57.29578, 0.5);
  EXPECT_GT(json["deviation_deg"].get<double>(), 0);
  EXPECT_LT(json["deviation_deg"].get<double>(), 2);
  EXPECT_TRUE(json.contains("runner_up_deg"));
  std::getline(lines, line);
  EXPECT_NEAR(Json::parse(line)["heading_deg"].get<double>(), 0, 0.1);
  const RunResult text = RunWaystone({"compass", a, b});
  EXPECT_NE(text.out.find("+28."), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("runner-up"), std::string::npos) << text.out;
}

TEST_F(PanoramaCommands, UnwrapWritesWhatIsUsed) {
  const fs::path a = Write("a.png", 0.1);
  const RunResult result = RunWaystone({"unwrap", a, "-o", folder_ / "out"});
  ASSERT_EQ(result.code, 0) << result.err;
  const cv::Mat drawn = cv::imread((folder_ / "out" / "a_used.png").string());
  EXPECT_EQ(drawn.size(), cv::Size(256, 128));
  EXPECT_FALSE(cv::imread((folder_ / "out" / "a_panorama.png").string()).empty());
}

TEST_F(PanoramaCommands, OneLineSaysWhatIsWrong) {
  const fs::path a = Write("a.png", 0.1);
  const RunResult one = RunWaystone({"compass", a});
  EXPECT_EQ(one.code, 2);
  EXPECT_NE(one.err.find("give at least 2"), std::string::npos) << one.err;
  cv::imwrite((folder_ / "black.png").string(), cv::Mat(128, 256, CV_8UC1, cv::Scalar(0)));
  const RunResult black = RunWaystone({"compass", a, folder_ / "black.png"});
  EXPECT_EQ(black.code, 3);
  EXPECT_NE(black.err.find("black.png"), std::string::npos) << black.err;
  EXPECT_NE(black.err.find("uncover the lens"), std::string::npos) << black.err;
  fs::create_directory(folder_ / "rig");
  const RunResult rig = RunWaystone({"unwrap", folder_ / "rig", "-o", folder_ / "out"});
  EXPECT_EQ(rig.code, 3);
  EXPECT_NE(rig.err.find("front"), std::string::npos) << rig.err;
}

}  // namespace
}  // namespace waystone
