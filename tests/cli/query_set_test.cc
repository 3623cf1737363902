// SPDX-License-Identifier: Apache-2.0
#include "cli/files/query_set.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/base/error.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

class PosedImages : public testing::Test {
 protected:
  PosedImages() { fs::create_directories(folder_); }
  ~PosedImages() override { fs::remove_all(folder_); }

  void Write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }

  // The x of the pose that an image of this name has, in whole metres, or the refusal.
  std::string XOf(const std::string& image, const std::string& truth) const {
    fs::remove_all(folder_ / "queries");
    fs::create_directories(folder_ / "queries");
    Write("queries/" + image, "");
    const ImagePoses poses(ReadPoseFile(folder_ / truth));
    try {
      const auto queries = ReadPosedImages(folder_ / "queries", poses, {}, 5);
      const TruePose pose = queries.at(0).pose.value();
      return std::to_string(std::lround(pose.world_from_camera.translation().x()));
    } catch (const MapError& error) {
      EXPECT_EQ(error.code(), ErrorCode::kNotFound);
      return error.what();
    }
  }

  void ExpectRefusal(const std::string& image, const std::string& truth,
                     const std::string& about) const {
    const std::string refusal = XOf(image, truth);
    EXPECT_NE(refusal.find(image + " has no pose in the file of --truth"), std::string::npos)
        << image << " " << truth << ": " << refusal;
    EXPECT_NE(refusal.find(about), std::string::npos) << image << " " << truth << ": " << refusal;
  }

  const fs::path folder_ =
      fs::temp_directory_path() / (std::string("waystone_posed_") +
                                   testing::UnitTest::GetInstance()->current_test_info()->name());
};

// Not by the image's place in the folder, which would be 0.
TEST_F(PosedImages, HaveThePoseOfTheNumberInTheirName) {
  Write("demo.csv", "frame,time_s,x,y,z\n0,0,0,0,0\n4,0.8,4,0,0\n22,4.4,22,0,0\n40,8,40,0,0\n");
  EXPECT_EQ(XOf("40.jpg", "demo.csv"), "40");
  EXPECT_EQ(XOf("IMG_000040.jpg", "demo.csv"), "40");
  EXPECT_EQ(XOf("4.4.jpg", "demo.csv"), "22");
  EXPECT_EQ(XOf("frame-4.4s.jpg", "demo.csv"), "22");
  EXPECT_EQ(XOf("000004_.jpg", "demo.csv"), "4");
  ExpectRefusal("IMG_000041.jpg", "demo.csv", "frame 000041");
  ExpectRefusal("5.5.jpg", "demo.csv", "time 5.5");
  for (const char* image : {"frame22_cam0.jpg", "v2_000022.jpg", "1.2.3.jpg", "photo.jpg"}) {
    ExpectRefusal(image, "demo.csv", "exactly one number");
  }
}

TEST_F(PosedImages, ATimeIsNoFrameNumber) {
  Write("frames.csv", "frame,x,y,z\n0,0,0,0\n4,4,0,0\n");
  ExpectRefusal("4.4.jpg", "frames.csv", "time 4.4");
  EXPECT_EQ(XOf("a4.jpg", "frames.csv"), "4");
  Write("tum.txt", "0 0 0 0 0 0 0 1\n4 40 0 0 0 0 0 1\n4.4 44 0 0 0 0 0 1\n");
  EXPECT_EQ(XOf("4.jpg", "tum.txt"), "40");
  EXPECT_EQ(XOf("4.4.jpg", "tum.txt"), "44");
  EXPECT_EQ(XOf("a1.jpg", "tum.txt"), "40") << "the line";
  EXPECT_EQ(XOf("99999999999999999999.jpg", "tum.txt").substr(0, 1), "/") << "a refusal";
}

TEST_F(PosedImages, GoByNameWhereThePosesHaveNames) {
  Write("named.csv", "image,x,y,z\nv2_000022.jpg,22,0,0\nIMG_1.png,1,0,0\n");
  EXPECT_EQ(XOf("v2_000022.jpg", "named.csv"), "22");
  EXPECT_EQ(XOf("IMG_1.jpg", "named.csv"), "1");
  ExpectRefusal("1.jpg", "named.csv", "by its name");
}

}  // namespace
}  // namespace waystone
