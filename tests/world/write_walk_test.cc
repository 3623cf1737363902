// SPDX-License-Identifier: Apache-2.0
#include "world/write_walk.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "core/base/error.h"
#include "tests/world/test_worlds.h"
#include "world/truth.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

class WriteWalkTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    dir_ = fs::path(testing::TempDir()) / (std::string("waystone_world_") + test->name());
    fs::remove_all(dir_);
    walk_.frames.resize(3);
    for (size_t i = 0; i < walk_.frames.size(); ++i) {
      walk_.frames[i].time_s = 0.1 * static_cast<double>(i);
      walk_.frames[i].world_from_camera = InWestRoom(0.1 * static_cast<double>(i));
    }
    options_.camera = SmallCamera();
    options_.render.noise_sigma = 2.0;
    options_.render.motion_samples = 2;
    options_.exposure_swing = 0.2;
  }
  void TearDown() override { fs::remove_all(dir_); }

  static std::string Read(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    EXPECT_TRUE(file.good()) << path;
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
  }
  static int Lines(const fs::path& path) {
    const std::string text = Read(path);
    return static_cast<int>(std::count(text.begin(), text.end(), '\n'));
  }

  fs::path dir_;
  Walk walk_;
  WriteWalkOptions options_;
};

TEST_F(WriteWalkTest, WritesPicturesAndTruth) {
  options_.format = "png";
  int last = 0;
  WriteWalk(TwoRoomWorld(), walk_, dir_, options_, [&](int done, int total) {
    EXPECT_EQ(done, ++last);
    EXPECT_EQ(total, 3);
  });
  EXPECT_EQ(last, 3);
  const RenderedFrame frame =
      Render(TwoRoomWorld(), options_.camera, walk_.frames[1].world_from_camera,
             FrameRenderOptions(walk_, 1, options_));
  const auto unchanged = cv::IMREAD_UNCHANGED;
  EXPECT_TRUE(SameBytes(cv::imread((dir_ / "images/000001.png").string(), unchanged), frame.grey));
  EXPECT_TRUE(
      SameBytes(cv::imread((dir_ / "plane_ids/000001.png").string(), unchanged), frame.plane_ids));
  EXPECT_EQ(Lines(dir_ / "poses.csv"), 4);
  EXPECT_EQ(Lines(dir_ / "planes.csv"), 1 + static_cast<int>(TwoRoomWorld().planes().size()));
  EXPECT_GT(Lines(dir_ / "adjacency.csv"), 20);
  EXPECT_NE(Read(dir_ / "camera.yaml").find("camera_model: PINHOLE\nimage_width: 160\n"),
            std::string::npos);
  EXPECT_EQ(Read(dir_ / "plan.txt"), TwoRooms().Text());
  const VisiblePlane seen = VisiblePlanes(frame.plane_ids).front();
  const std::string row =
      "\n1," + std::to_string(seen.plane) + ',' + std::to_string(seen.pixels) + '\n';
  EXPECT_NE(Read(dir_ / "visible.csv").find(row), std::string::npos);
  EXPECT_TRUE(fs::exists(dir_ / "README.txt"));
  EXPECT_FALSE(fs::exists(dir_ / "rig"));
}

TEST_F(WriteWalkTest, WritesRigAndPanoramaAlone) {
  options_.pinhole = false;
  options_.rig = true;
  options_.panorama = true;
  options_.rig_width_px = 32;
  options_.panorama_width_px = 128;
  WriteWalk(TwoRoomWorld(), walk_, dir_, options_);
  for (const char* name : {"front", "right", "back", "left", "up", "down"}) {
    EXPECT_EQ(cv::imread((dir_ / "rig" / name / "000002.jpg").string()).cols, 32) << name;
  }
  EXPECT_EQ(cv::imread((dir_ / "panorama/000000.jpg").string()).rows, 64);
  EXPECT_FALSE(fs::exists(dir_ / "images"));
  EXPECT_FALSE(fs::exists(dir_ / "visible.csv"));
}

TEST_F(WriteWalkTest, WritesTheSameBytesOnOneThreadAndOnMany) {
  WriteWalk(TwoRoomWorld(), walk_, dir_ / "many", options_);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  WriteWalk(TwoRoomWorld(), walk_, dir_ / "one", options_);
  int files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(dir_ / "many")) {
    if (!entry.is_regular_file()) continue;
    ++files;
    EXPECT_EQ(Read(entry.path()), Read(dir_ / "one" / fs::relative(entry, dir_ / "many")));
  }
  EXPECT_EQ(files, 7 + 2 * 3);
}

TEST_F(WriteWalkTest, RefusesFullFoldersFilesAndBadOptions) {
  const auto code_of = [&](const fs::path& path) {
    try {
      WriteWalk(TwoRoomWorld(), walk_, path, options_);
    } catch (const MapError& error) {
      return error.code();
    }
    return ErrorCode::kInternal;
  };
  fs::create_directories(dir_);
  std::ofstream(dir_ / "file") << "mine";
  EXPECT_EQ(code_of(dir_), ErrorCode::kFileExists);
  EXPECT_EQ(Read(dir_ / "file"), "mine");
  EXPECT_EQ(code_of(dir_ / "file" / "sub"), ErrorCode::kFileUnwritable);
  EXPECT_EQ(code_of(dir_ / "file"), ErrorCode::kFileUnwritable);
  options_.format = "gif";
  EXPECT_EQ(code_of(dir_ / "new"), ErrorCode::kBadOptions);
  options_.format = "jpg";
  options_.camera = PanoramaCamera(64);
  EXPECT_EQ(code_of(dir_ / "new"), ErrorCode::kBadOptions);
  EXPECT_FALSE(fs::exists(dir_ / "new"));
}

}  // namespace
}  // namespace waystone
