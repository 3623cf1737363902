// SPDX-License-Identifier: Apache-2.0
#include "tests/builder/sources/temporary_folder.h"

namespace waystone {
namespace {

using Strings = std::vector<std::string>;

class TumTest : public TemporaryFolder {};

TEST_F(TumTest, FramesInTheOrderOfTheListWithTheirTimes) {
  WriteImage("rgb/b.png", 1);
  WriteImage("rgb/a.png", 2);
  WriteImage("rgb/unlisted.png");
  WriteImage("depth/a.png");
  Write("rgb.txt", "# timestamp filename\r\n1305031102.175304 rgb/b.png\r\n\n0.5e3 rgb/a.png\n");
  const auto source = Open();
  EXPECT_EQ(source->kind(), "tum");
  EXPECT_EQ(source->name(), folder_.filename());
  EXPECT_EQ(source->Announcement(), "TUM sequence, 2 frames 16x12");
  EXPECT_FALSE(source->camera());
  const std::vector<Frame> frames = AllFrames(*source);
  EXPECT_EQ(NamesOf(frames), (Strings{"rgb/b.png", "rgb/a.png"}));
  EXPECT_DOUBLE_EQ(frames[0].info.time_s.value(), 1305031102.175304);
  EXPECT_DOUBLE_EQ(frames[1].info.time_s.value(), 500);
  EXPECT_EQ(frames[1].grey.at<uint8_t>(0, 0), 2);
}

TEST_F(TumTest, AByteOrderMarkIsNoPartOfTheList) {
  WriteImage("rgb/a.png", 1);
  Write("rgb.txt",
        "\xef\xbb\xbf"
        "0.5 rgb/a.png\n");
  const std::vector<Frame> frames = AllFrames(*Open());
  ASSERT_EQ(frames.size(), 1);
  EXPECT_EQ(frames[0].info.time_s, 0.5);
}

TEST_F(TumTest, CameraBesideTheList) {
  WriteImage("rgb/a.png");
  Write("rgb.txt", "0 rgb/a.png\n");
  Write("camera.yaml",
        "camera_model: SIMPLE_PINHOLE\nimage_width: 16\nimage_height: 12\nf: 20\ncx: 8\ncy: 6\n");
  EXPECT_EQ(Open()->camera()->model, CameraModel::kSimplePinhole);
}

TEST_F(TumTest, AMissingFileIsAFrameWithAnError) {
  WriteImage("rgb/a.png");
  Write("rgb.txt", "0 rgb/gone.png\n1 rgb/a.png\n");
  const std::vector<Frame> frames = AllFrames(*Open());
  ASSERT_EQ(frames.size(), 2);
  EXPECT_NE(frames[0].error.find("does not exist"), std::string::npos);
  EXPECT_EQ(frames[1].error, "");
}

TEST_F(TumTest, BadListsAreRefusedWithTheirLine) {
  Write("rgb.txt", "# nothing\n");
  ExpectError([&] { Open(); }, ErrorCode::kBadSource, {"rgb.txt", "lists no image"});
  Write("rgb.txt", "0 rgb/a.png\nsoon rgb/b.png\n");
  ExpectError([&] { Open(); }, ErrorCode::kBadSource, {"rgb.txt' line 2", "soon", "a time"});
  Write("rgb.txt", "nan rgb/a.png\n");
  ExpectError([&] { Open(); }, ErrorCode::kBadSource, {"line 1", "a time"});
  Write("rgb.txt", "# two words\n\n0\n");
  ExpectError([&] { Open(); }, ErrorCode::kBadSource, {"line 3"});
  for (const char* outside : {"/etc/a.png", "../a.png", "rgb/../../a.png"}) {
    Write("rgb.txt", std::string("0 ") + outside + "\n");
    ExpectError([&] { Open(); }, ErrorCode::kBadSource, {"line 1", "file in the same folder"});
  }
  Write("rgb.txt", "0 rgb/gone.png\n");
  ExpectError([&] { Open(); }, ErrorCode::kBadSource, {"none of the 1 frames"});
}

class KittiTest : public TemporaryFolder {
 protected:
  void SetUp() override {
    TemporaryFolder::SetUp();
    for (int i = 0; i < 3; ++i) WriteImage("image_0/00000" + std::to_string(i) + ".png", i);
    Write("times.txt", "0.0\n1.036e-01\n2.0e-1\n");
    Write("calib.txt", "P0: 70 0 8 0 0 71 6 0 0 0 1 0\nP1: 0\nP2: 80 0 9 4 0 81 5 0 0 0 1 0\n");
  }
};

TEST_F(KittiTest, FramesTimesAndCamera) {
  const auto source = Open();
  EXPECT_EQ(source->kind(), "kitti");
  EXPECT_EQ(source->Announcement(), "KITTI sequence, 3 frames 16x12");
  EXPECT_EQ(source->camera(), (Camera{CameraModel::kPinhole, 16, 12, {70, 71, 8, 6}}));
  const std::vector<Frame> frames = AllFrames(*source);
  EXPECT_EQ(frames[1].info.source, "image_0/000001.png");
  EXPECT_DOUBLE_EQ(frames[1].info.time_s.value(), 0.1036);
  EXPECT_EQ(frames[2].grey.at<uint8_t>(0, 0), 2);
}

TEST_F(KittiTest, ColourFolderHasItsOwnMatrix) {
  std::filesystem::rename(folder_ / "image_0", folder_ / "image_2");
  EXPECT_EQ(Open()->camera(), (Camera{CameraModel::kPinhole, 16, 12, {80, 81, 9, 5}}));
}

TEST_F(KittiTest, TimesFollowTheNumberOfTheImage) {
  std::filesystem::remove(folder_ / "image_0/000000.png");
  WriteImage("image_0/000007.png");
  const std::vector<Frame> frames = AllFrames(*Open());
  ASSERT_EQ(frames.size(), 3);
  EXPECT_DOUBLE_EQ(frames[0].info.time_s.value(), 0.1036);
  EXPECT_FALSE(frames[2].info.time_s);
}

TEST_F(KittiTest, WorksWithoutTimesOrCalibration) {
  std::filesystem::remove(folder_ / "times.txt");
  EXPECT_FALSE(AllFrames(*Open())[0].info.time_s);
  std::filesystem::remove(folder_ / "calib.txt");
  Write("times.txt", "0\n1\n2\n");
  EXPECT_FALSE(Open()->camera());
}

TEST_F(KittiTest, BadCalibrationsAndTimes) {
  Write("calib.txt", "P0: 70 0 8 0 0 71\n");
  ExpectError([&] { Open(); }, ErrorCode::kBadCamera, {"calib.txt' line 1", "P0 has 6 numbers"});
  Write("calib.txt", "P3: 1\n");
  ExpectError([&] { Open(); }, ErrorCode::kBadCamera, {"no line 'P0:'"});
  Write("calib.txt", "P0: -70 0 8 0 0 71 6 0 0 0 1 0\n");
  ExpectError([&] { Open(); }, ErrorCode::kBadCamera, {"parameter 1"});
  Write("calib.txt", "P0: nan 0 8 0 0 71 6 0 0 0 1 0\n");
  ExpectError([&] { Open(); }, ErrorCode::kBadCamera, {"P0 has 11 numbers"});
  Write("times.txt", "0\ninf\n");
  ExpectError([&] { Open(); }, ErrorCode::kBadSource, {"times.txt' line 2"});
  Write("times.txt", "0\nnever\n");
  ExpectError([&] { Open(); }, ErrorCode::kBadSource, {"times.txt' line 2"});
  Write("times.txt", "# s\n0\n0\n0.2\n0.1\n");
  ExpectError([&] { Open(); }, ErrorCode::kBadSource,
              {"times.txt' line 5: '0.1' is not a time at or after that of the line before"});
}

class EurocTest : public TemporaryFolder {
 protected:
  void SetUp() override {
    TemporaryFolder::SetUp();
    WriteImage("mav0/cam0/data/1403636579763555584.png", 3);
    WriteImage("mav0/cam0/data/1403636579813555456.png", 4);
    Write("mav0/cam0/data.csv",
          "#timestamp [ns],filename\r\n1403636579763555584,1403636579763555584.png\r\n"
          "1403636579813555456, 1403636579813555456.png\r\n");
    Write("mav0/cam0/sensor.yaml",
          "sensor_type: camera\nresolution: [16, 12]\ncamera_model: pinhole\n"
          "intrinsics: [20.5, 21, 8, 6] #fu, fv, cu, cv\n"
          "distortion_model: radial-tangential\n"
          "distortion_coefficients: [-0.28, 0.07, 0.0002, 1.8e-05]\n");
  }
};

TEST_F(EurocTest, FramesTimesAndCamera) {
  const auto source = Open();
  EXPECT_EQ(source->kind(), "euroc");
  EXPECT_EQ(source->Announcement(), "EuRoC sequence, 2 frames 16x12");
  EXPECT_EQ(source->camera(),
            (Camera{CameraModel::kOpenCv, 16, 12, {20.5, 21, 8, 6, -0.28, 0.07, 0.0002, 1.8e-05}}));
  const std::vector<Frame> frames = AllFrames(*source);
  ASSERT_EQ(frames.size(), 2);
  EXPECT_EQ(frames[0].info.source, "mav0/cam0/data/1403636579763555584.png");
  EXPECT_NEAR(frames[1].info.time_s.value(), 1403636579.813555456, 1e-6);
  EXPECT_EQ(frames[1].grey.at<uint8_t>(0, 0), 4);
}

TEST_F(EurocTest, ItsInnerFoldersAreRecognisedToo) {
  EXPECT_EQ(OpenSource((folder_ / "mav0").string(), {})->kind(), "euroc");
  const auto inner = OpenSource((folder_ / "mav0/cam0").string(), {});
  EXPECT_EQ(inner->kind(), "euroc");
  EXPECT_EQ(inner->Next()->info.source, "data/1403636579763555584.png");
}

TEST_F(EurocTest, BadListsAreRefusedWithTheirLine) {
  Write("mav0/cam0/data.csv", "#timestamp [ns],filename\n12.5,a.png\n");
  ExpectError([&] { Open(); }, ErrorCode::kBadSource, {"data.csv' line 2", "nanoseconds"});
  Write("mav0/cam0/data.csv", "12,../../../a.png\n");
  ExpectError([&] { Open(); }, ErrorCode::kBadSource, {"data.csv' line 1", "a file in data"});
  Write("mav0/cam0/data.csv", ",\n");
  ExpectError([&] { Open(); }, ErrorCode::kBadSource, {"data.csv' line 1"});
  Write("mav0/cam0/data.csv", "");
  ExpectError([&] { Open(); }, ErrorCode::kBadSource, {"lists no image"});
}

}  // namespace
}  // namespace waystone
