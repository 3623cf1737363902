// SPDX-License-Identifier: Apache-2.0
// `waystone merge`, `add`, `prune` and `remove` as a user runs them.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
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

TEST_F(JoiningTest, ANamedPlaceIsRemoved) {
  const size_t keyframes = CountKeyframes();
  ASSERT_EQ(RunWaystone({"name", map_, "Window", "--keyframes", "1:2"}).code, 0);
  const RunResult removed = RunWaystone({"remove", map_, "--place", "Window", "--json"});
  ASSERT_EQ(removed.code, 0) << removed.err;
  EXPECT_EQ(CountKeyframes(), keyframes - 2);
  ExpectRefusal({"remove", map_, "--place", "Cellar"}, 3, "Cellar");
}

TEST_F(JoiningTest, RemoveRefusesWhatTheMapHasNot) {
  ExpectRefusal({"remove", map_}, 2, "nothing to remove");
  ExpectRefusal({"remove", map_, "--keyframes", "3-5"}, 2, "'3-5' is not an id");
  ExpectRefusal({"remove", map_, "--keyframes", "1:99999"}, 3, "no keyframe 99999");
  ExpectRefusal({"remove", map_, "--session", "night"}, 3, "no session 'night'");
}

TEST_F(JoiningTest, OneMapIsNothingToMerge) {
  ExpectRefusal({"merge", map_, "-o", folder_ / "floor.db"}, 2, "two or more");
  EXPECT_FALSE(fs::exists(folder_ / "floor.db"));
}

TEST_F(JoiningTest, OrientationLayersAreJoinedAndPared) {
  const std::string corner = TheCorner().map;
  const fs::path both = folder_ / "both.db";
  const RunResult merged = RunWaystone({"merge", map_, corner, "-o", both, "--json"});
  ASSERT_EQ(merged.code, 0) << merged.err;
  const Json summary = Json::parse(merged.out);
  EXPECT_GT(summary["orientation_frames"], 0);
  EXPECT_EQ(summary["sessions"].size(), 2u);
  EXPECT_EQ(summary["parts"].size(), 2u);  // other rooms
  EXPECT_EQ(RunWaystone({"check", both}).code, 0);
  ASSERT_EQ(RunWaystone({"remove", both, "--session", TheCorner().map.stem()}).code, 0);
  EXPECT_EQ(RunWaystone({"check", both}).code, 0);
  EXPECT_EQ(Json::parse(RunWaystone({"info", both, "--json"}).out)["keyframes"], CountKeyframes());
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

// Panoramas of one place: noise that turns.
void WritePanoramas(const fs::path& folder, int count, uint64_t seed) {
  fs::create_directory(folder);
  cv::Mat noise(128, 256, CV_8U);
  cv::RNG(seed).fill(noise, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(noise, noise, {9, 9}, 3);
  cv::Mat twice;
  cv::hconcat(noise, noise, twice);
  for (int i = 0; i < count; ++i) {
    cv::imwrite((folder / (std::to_string(i) + ".png")).string(),
                twice(cv::Rect(5 * i, 0, 256, 128)));
  }
}

TEST_F(JoiningTest, PanoramasAreAddedAndRemoved) {
  WritePanoramas(folder_ / "walk", 4, 7);
  const RunResult added =
      RunWaystone({"add", map_, folder_ / "walk", "--name", "round", "--json", "--quiet"});
  ASSERT_EQ(added.code, 0) << added.err;
  EXPECT_GE(Json::parse(added.out)["panoramas"], 3);  // a redundant one is dropped
  EXPECT_EQ(Json::parse(added.out)["parts"].size(), 2u);
  const Json round = Json::parse(added.out)["sessions"][1];
  EXPECT_EQ(round["panoramas"], Json::parse(added.out)["panoramas"]);
  EXPECT_EQ(round["keyframes"], 0);
  EXPECT_NE(RunWaystone({"info", map_})
                .out.find("0 keyframes, " + round["panoramas"].dump() + " panoramas"),
            std::string::npos);
  EXPECT_EQ(RunWaystone({"check", map_}).code, 0);
  const RunResult pared = RunWaystone({"remove", map_, "--nodes", "2:3", "--json"});
  ASSERT_EQ(pared.code, 0) << pared.err;
  EXPECT_EQ(Json::parse(pared.out)["removed"]["panoramas"], 2);
  ExpectRefusal({"remove", map_, "--nodes", "2"}, 3, "no node 2");
  ASSERT_EQ(RunWaystone({"remove", map_, "--session", "round"}).code, 0);
  EXPECT_EQ(RunWaystone({"check", map_}).code, 0);
}

TEST_F(JoiningTest, WhatALaterWalkDidNotFindIsPruned) {
  ExpectRefusal({"prune", map_}, 3, "was never looked at again; add a walk first (waystone add)");
  RenderPosters("####a###b###c###", folder_ / "before", 10, 40);
  RenderPosters("####a#######d###", folder_ / "later", 12, 42);
  ASSERT_EQ(RunWaystone({"build", folder_ / "before", "-o", map_, "--force", "--quiet"}).code, 0);
  const RunResult added =
      RunWaystone({"add", map_, folder_ / "later", "--name", "later", "--json", "--quiet"});
  ASSERT_EQ(added.code, 0) << added.err;
  EXPECT_GT(Json::parse(added.out)["features_looked_for"], 300);
  EXPECT_EQ(RunWaystone({"check", map_}).code, 0);
  const std::string grown = ReadFile(map_);
  const RunResult asked = RunWaystone({"prune", map_, "--dry-run", "--json"});
  ASSERT_EQ(asked.code, 0) << asked.err;
  EXPECT_TRUE(ReadFile(map_) == grown);
  const Json summary = Json::parse(asked.out);
  EXPECT_GT(summary["removed"]["plane_features"], 20) << asked.out;
  ASSERT_EQ(summary["not_found_by"].size(), 1u) << asked.out;
  EXPECT_EQ(summary["not_found_by"][0]["session"], "later");

  const RunResult patient =
      RunWaystone({"prune", map_, "--dry-run", "--min-looks", "1000", "--json"});
  EXPECT_EQ(Json::parse(patient.out)["removed"]["plane_features"], 0) << patient.out;

  const RunResult pruned = RunWaystone({"prune", map_, "--keep", "--json"});
  ASSERT_EQ(pruned.code, 0) << pruned.err;
  EXPECT_EQ(pruned.out, asked.out);
  EXPECT_TRUE(ReadFile(map_.string() + ".previous") == grown);
  EXPECT_FALSE(ReadFile(map_) == grown);
  EXPECT_EQ(RunWaystone({"check", map_}).code, 0);
  const Json info = Json::parse(RunWaystone({"info", map_, "--json"}).out);
  EXPECT_EQ(info["sessions"], summary["sessions"]);
  EXPECT_EQ(info["sessions"].size(), 2u);
  EXPECT_EQ(info["parts"].size(), 1u);
  const fs::path photo = folder_ / "later" / "25.jpg";
  EXPECT_EQ(Json::parse(RunWaystone({"localize", map_, photo, "--json"}).out)["verdict"],
            "localized");
  // Nothing is left to do, and the file stays as it is.
  const std::string left = ReadFile(map_);
  EXPECT_EQ(Json::parse(RunWaystone({"prune", map_, "--json"}).out)["removed"]["plane_features"],
            0);
  EXPECT_TRUE(ReadFile(map_) == left);
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
