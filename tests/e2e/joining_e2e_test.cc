// SPDX-License-Identifier: Apache-2.0
// `waystone merge`, `add` and `remove` as a user runs them.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "api/json.h"
#include "tests/e2e/calibrated_maps.h"
#include "tests/e2e/shared_map.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

class JoiningTest : public testing::Test {
 protected:
  JoiningTest() { fs::copy_file(TheMap().map, map_); }
  ~JoiningTest() override { fs::remove_all(folder_); }

  // Refused in one line, with the map as it was.
  void ExpectRefusal(const std::vector<std::string>& arguments, int code,
                     const std::string& about) const {
    const std::string before = ReadFile(map_);
    const RunResult result = RunWaystone(arguments);
    EXPECT_EQ(result.code, code) << result.err;
    EXPECT_EQ(result.out, "");
    EXPECT_EQ(std::ranges::count(result.err, '\n'), 1) << result.err;
    EXPECT_NE(result.err.find(about), std::string::npos) << result.err;
    EXPECT_TRUE(ReadFile(map_) == before) << about;
  }

  size_t CountKeyframes() const {
    return Json::parse(RunWaystone({"info", map_, "--json"}).out)["keyframes"];
  }

  const fs::path folder_ = FreshFolder();
  const fs::path map_ = folder_ / "room.db";
};

TEST_F(JoiningTest, RemovedKeyframesAreGoneAndThePreviousVersionIsKept) {
  const std::string before = ReadFile(map_);
  const size_t keyframes = CountKeyframes();
  const RunResult removed =
      RunWaystone({"remove", map_, "--keyframes", "2:3,5", "--keyframes", "3", "--keep", "--json"});
  ASSERT_EQ(removed.code, 0) << removed.err;
  EXPECT_EQ(Json::parse(removed.out)["removed"]["keyframes"], 3);
  EXPECT_EQ(CountKeyframes(), keyframes - 3);
  EXPECT_EQ(RunWaystone({"check", map_}).code, 0);
  EXPECT_TRUE(ReadFile(map_.string() + ".previous") == before);
}

TEST_F(JoiningTest, RemoveRefusesWhatTheMapHasNot) {
  ExpectRefusal({"remove", map_}, 2, "nothing to remove");
  ExpectRefusal({"remove", map_, "--keyframes", "3-5"}, 2, "'3-5' is not an id");
  ExpectRefusal({"remove", map_, "--keyframes", "1:99999"}, 3, "no keyframe 99999");
  ExpectRefusal({"remove", map_, "--session", "night"}, 3, "no session 'night'");
}

TEST_F(JoiningTest, MapsWithAnOrientationLayerAreRefused) {
  const std::string corner = TheCorner().map;
  ExpectRefusal({"remove", corner, "--keyframes", "1"}, 3, "has an orientation layer");
  ExpectRefusal({"merge", map_, corner, "-o", folder_ / "both.db"}, 3, "has an orientation layer");
  EXPECT_FALSE(fs::exists(folder_ / "both.db"));
}

TEST_F(JoiningTest, WhatIsLeftOfAMapWithPosesAnswersWithThem) {
  fs::copy_file(ThePosedHall().map, map_, fs::copy_options::overwrite_existing);
  ASSERT_EQ(RunWaystone({"remove", map_, "--keyframes", "1"}).code, 0);
  EXPECT_EQ(RunWaystone({"check", map_}).code, 0);
  const fs::path photo = ThePosedHall().walk / "queries" / "20.jpg";
  const Json answer = Json::parse(RunWaystone({"localize", map_, photo, "--json"}).out);
  ASSERT_EQ(answer["verdict"], "localized");
  EXPECT_TRUE(answer["pose"].is_object()) << answer;
}

TEST_F(JoiningTest, PanoramasAreRefusedBeforeTheyAreBuilt) {
  fs::create_directory(folder_ / "walk");
  for (int i = 0; i < 3; ++i) {
    cv::imwrite((folder_ / "walk" / (std::to_string(i) + ".png")).string(),
                cv::Mat(128, 256, CV_8U, cv::Scalar(90)));
  }
  ExpectRefusal({"add", map_, folder_ / "walk", "--quiet"}, 3, "layers beside planes");
}

TEST_F(JoiningTest, AWalkThatShowsNothingIsNotAdded) {
  fs::create_directory(folder_ / "dark");
  for (int i = 0; i < 3; ++i) {
    cv::imwrite((folder_ / "dark" / (std::to_string(i) + ".png")).string(),
                cv::Mat(480, 640, CV_8U, cv::Scalar(20)));
  }
  ExpectRefusal({"add", map_, folder_ / "dark", "--quiet"}, 4, "no plane or landmark found");
}

}  // namespace
}  // namespace waystone
