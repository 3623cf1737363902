// SPDX-License-Identifier: Apache-2.0
#include "builder/sources/rig_source.h"

#include <Eigen/Geometry>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>

#include "builder/sources/rig_layouts.h"
#include "builder/sources/source.h"
#include "tests/builder/sources/temporary_folder.h"

namespace waystone {
namespace {

class RigSourceTest : public TemporaryFolder {
 protected:
  RigSequence Open(const RigOptions& options = {}) { return OpenRigSequence(folder_, options); }

  void ExpectRefusal(ErrorCode code, const std::vector<std::string>& parts) {
    ExpectError([&] { Open(); }, code, parts);
  }
};

constexpr std::array kFaces{"front", "right", "back", "left", "up", "down"};

// Kalibr's camchain: two cameras, the second 0.1 m to the right of the first and turned by 90
// degrees to the right.
std::string Camchain(const std::string& second = "cam1") {
  const std::string camera =
      "  camera_model: pinhole\n  intrinsics: [50, 51, 31, 23]\n  distortion_model: radtan\n"
      "  distortion_coeffs: [0.1, 0, 0, 0]\n  resolution: [64, 48]\n";
  return "cam0:\n" + camera + second + ":\n" + camera +
         "  T_cn_cnm1:\n  - [0, 0, -1, 0]\n  - [0, 1, 0, 0]\n  - [1, 0, 0, -0.1]\n"
         "  - [0, 0, 0, 1]\n";
}

TEST_F(RigSourceTest, KalibrsChainOfPoses) {
  const Rig rig = ReadRigFile(Write("camchain.yaml", Camchain()));
  ASSERT_EQ(rig.cameras.size(), 2u);
  EXPECT_EQ(rig.cameras[1].name, "cam1");
  EXPECT_TRUE(rig.cameras[0].rig_from_camera.matrix().isIdentity());
  const Eigen::Isometry3d& pose = rig.cameras[1].rig_from_camera;
  EXPECT_TRUE(pose.translation().isApprox(Eigen::Vector3d(0.1, 0, 0), 1e-12));
  EXPECT_TRUE((pose.linear() * Eigen::Vector3d::UnitZ()).isApprox(Eigen::Vector3d::UnitX(), 1e-12));
}

TEST_F(RigSourceTest, ChainsWithGapsAreRefused) {
  const auto read = [&](const std::string& text) {
    return [this, text] { ReadRigFile(Write("camchain.yaml", text)); };
  };
  ExpectError(read(Camchain("cam2")), ErrorCode::kBadCamera, {"camchain.yaml", "cam1 is missing"});
  std::string text = Camchain();
  text.replace(text.find("T_cn_cnm1"), 9, "T_cam_imu");
  ExpectError(read(text), ErrorCode::kBadCamera, {"T_cn_cnm1 is missing"});
  text = Camchain();
  text.replace(text.find("[0, 1, 0, 0]"), 12, "[0, 2, 0, 0]");
  ExpectError(read(text), ErrorCode::kBadCamera, {"T_cn_cnm1 must be a rotation"});
  text = Camchain();
  text.replace(text.find("[64,"), 4, "[.nan,");
  ExpectError(read(text), ErrorCode::kBadCamera, {"not a number"});
  text = Camchain();
  text.replace(text.find("[0, 1, 0, 0]"), 12, "[0, 1, 0]");
  ExpectError(read(text), ErrorCode::kBadCamera, {"T_cn_cnm1 must be 4 rows of 4"});
}

std::string OwnRig(const std::string& second_pose, const std::string& second_name = "side") {
  const std::string camera =
      "    camera_model: PINHOLE\n    image_width: 16\n    image_height: 12\n    fx: 10\n"
      "    fy: 10\n    cx: 7.5\n    cy: 5.5\n";
  return "cameras:\n  - name: ahead\n" + camera + "    rig_from_camera_xyzw: [0, 0, 0, 1]\n" +
         "  - name: " + second_name + "\n" + camera + second_pose;
}

constexpr const char* kSidePose =
    "    rig_from_camera_xyzw: [0, 0.70710678, 0, 0.70710678]\n"
    "    rig_from_camera_m: [0.2, 0, 0]\n";

TEST_F(RigSourceTest, OwnFile) {
  const Rig rig = ReadRigFile(Write("rig.yaml", OwnRig(kSidePose)));
  ASSERT_EQ(rig.cameras.size(), 2u);
  const Eigen::Vector3d there = rig.cameras[1].rig_from_camera * Eigen::Vector3d::UnitZ();
  EXPECT_TRUE(there.isApprox(Eigen::Vector3d(1.2, 0, 0), 1e-6)) << there.transpose();
}

TEST_F(RigSourceTest, OwnFilesThatAreWrong) {
  const auto read = [&](const std::string& text) {
    return [this, text] { ReadRigFile(Write("rig.yaml", text)); };
  };
  ExpectError(read(OwnRig("")), ErrorCode::kBadCamera,
              {"rig.yaml", "rig_from_camera_xyzw is missing"});
  ExpectError(read(OwnRig("    rig_from_camera_xyzw: [0, 0, 0, 2]\n")), ErrorCode::kBadCamera,
              {"length 2", "unit quaternion"});
  ExpectError(read(OwnRig(kSidePose, "ahead")), ErrorCode::kBadCamera, {"'ahead' is duplicated"});
  ExpectError(read("cameras: 5\n"), ErrorCode::kBadCamera, {"cameras must be a list"});
  ExpectError(read("cameras: []\n"), ErrorCode::kBadCamera, {"a rig of 0 cameras"});
  ExpectError(read("cameras: [7]\n"), ErrorCode::kBadCamera, {"rig.yaml"});
  ExpectError(read("cameras: [[7]]\n"), ErrorCode::kBadCamera, {"its keys (none)"});
  ExpectError(read("cam0: [name: a]\n"), ErrorCode::kBadCamera, {"its keys (none)"});
}

TEST_F(RigSourceTest, ParallelFolders) {
  Write("rig.yaml", OwnRig(kSidePose));
  for (int i = 0; i < 3; ++i) {
    WriteImage("ahead/" + std::to_string(i) + ".png", 10 + i);
    WriteImage("side/" + std::to_string(i) + ".png", 20 + i);
  }
  const RigSequence sequence = Open();
  EXPECT_EQ(sequence.layout, "parallel folders");
  ASSERT_EQ(sequence.moments.size(), 3u);
  const auto images = ReadMoment(sequence, sequence.moments[2]);
  ASSERT_EQ(images.size(), 2u);
  EXPECT_EQ(images[0].at<uchar>(0, 0), 12);
  EXPECT_EQ(images[1].at<uchar>(0, 0), 22);
}

// As a map is built of it: frames of the first camera, with the images of all of them.
TEST_F(RigSourceTest, ACalibratedRigIsASource) {
  Write("rig.yaml", OwnRig(kSidePose));
  for (int i = 0; i < 3; ++i) {
    WriteImage("ahead/" + std::to_string(i) + ".png", 10 + i);
    WriteImage("side/" + std::to_string(i) + ".png", 20 + i);
  }
  const auto source = OpenSource(folder_.string(), {.every = 2});
  EXPECT_EQ(source->kind(), "cameras");
  EXPECT_EQ(source->size(), 2);
  EXPECT_EQ(source->Announcement(), "Rig of 2 cameras, 3 moments, 2 used");
  ASSERT_TRUE(source->faces().has_value());
  EXPECT_EQ(source->faces()->cameras[1].name, "side");
  EXPECT_EQ(source->camera()->width, 16);
  source->NextEncoded();
  const auto last = source->NextEncoded();
  ASSERT_TRUE(last.has_value());
  EXPECT_EQ(last->info().number, 2);
  const auto images = last->Load();
  ASSERT_EQ(images.size(), 2u);
  EXPECT_EQ(images[1].at<uchar>(0, 0), 22);
  EXPECT_EQ(last->Decode().grey.at<uchar>(0, 0), 12);
  EXPECT_FALSE(source->NextEncoded().has_value());
}

// What all cameras say of a rotation has to hold for the first one's images.
TEST_F(RigSourceTest, TheFrameOfACalibratedRigIsItsFirstCameras) {
  WriteImage("ahead/0.png");
  WriteImage("side/0.png");
  for (const double degrees : {90.0, 45.0}) {
    const double half = 0.5 * degrees * std::numbers::pi / 180;
    std::string text = OwnRig(kSidePose);
    const std::string identity = "[0, 0, 0, 1]";
    text.replace(text.find(identity), identity.size(),
                 "[0, " + std::to_string(std::sin(half)) + ", 0, " +
                     std::to_string(std::cos(half)) + "]\n    rig_from_camera_m: [0.1, 0, 0.3]");
    const Rig file = ReadRigFile(Write("rig.yaml", text));
    const Rig rig = *OpenSource(folder_.string(), {})->faces();
    const Eigen::Isometry3d first = file.cameras[0].rig_from_camera;
    ASSERT_GT(Eigen::AngleAxisd(first.linear()).angle(), 0.7);
    EXPECT_TRUE(rig.cameras[0].rig_from_camera.matrix().isIdentity(1e-12));
    EXPECT_TRUE(
        (first * rig.cameras[1].rig_from_camera).isApprox(file.cameras[1].rig_from_camera, 1e-12));
  }
}

TEST_F(RigSourceTest, TheLargestStepTakesTheFirstMoment) {
  const auto size_by_step = [&] {
    const auto source =
        OpenSource(folder_.string(), {.every = std::numeric_limits<int>::max(), .from = 1});
    EXPECT_TRUE(source->faces().has_value());
    return AllFrames(*source).size();
  };
  for (int i = 0; i < 3; ++i) {
    for (const char* face : kFaces) {
      WriteImage(std::string(face) + "/" + std::to_string(i) + ".png", 50, {32, 32});
    }
  }
  EXPECT_EQ(size_by_step(), 1u);
  Write("rig.yaml", OwnRig(kSidePose));
  for (int i = 0; i < 3; ++i) {
    WriteImage("ahead/" + std::to_string(i) + ".png");
    WriteImage("side/" + std::to_string(i) + ".png");
  }
  EXPECT_EQ(size_by_step(), 1u);
}

// A file of the deepest format may be as large in a rig as in a folder.
TEST_F(RigSourceTest, DeepColourImagesAreWithinTheLimits) {
  Write("rig.yaml", OwnRig(kSidePose));
  DecodeLimits limits;
  limits.max_pixels = 1'000'000;
  const std::string deep(size_t{6} * limits.max_pixels, 'd');
  for (const char* camera : {"ahead", "side"}) {
    Write(std::string(camera) + "/0.ppm", "P6 1000 1000 65535 " + deep);
  }
  const RigSequence sequence = Open();
  ExpectError([&] { ReadMoment(sequence, sequence.moments[0], limits); }, ErrorCode::kBadImage,
              {"1000x1000"});
}

TEST_F(RigSourceTest, ASourceWhoseRigLacksImages) {
  const auto chain = Write("camchain.yaml", Camchain());
  WriteImage("cam0/0.png", 1, {64, 48});
  WriteImage("cam0/1.png", 1, {64, 48});
  SourceOptions options;
  options.camera_file = chain;
  const auto open = [&] { OpenSource(folder_.string(), options); };
  ExpectError(open, ErrorCode::kBadSource, {"no images of camera 'cam1'", "remove the camera"});
  WriteImage("cam1/0.png", 1, {64, 48});
  ExpectError(open, ErrorCode::kBadSource, {"'cam1' has 1 images", "'cam0' has 2"});
  WriteImage("cam1/1.png", 1, {32, 48});
  const auto source = OpenSource(folder_.string(), options);
  EXPECT_EQ(source->Next()->error, "");
  EXPECT_NE(source->Next()->error.find("1.png"), std::string::npos)
      << "wrong size, the rest goes on";
}

TEST_F(RigSourceTest, FacesOfNinetyDegreesAreAPanorama) {
  for (const char* face : kFaces) WriteImage(std::string(face) + "/0.jpg", 50, {32, 32});
  EXPECT_EQ(OpenSource(folder_.string(), {})->kind(), "rig");
}

TEST_F(RigSourceTest, FoldersOfDifferentLengths) {
  Write("rig.yaml", OwnRig(kSidePose));
  for (int i = 0; i < 3; ++i) WriteImage("ahead/" + std::to_string(i) + ".png");
  WriteImage("side/0.png");
  ExpectRefusal(ErrorCode::kBadSource, {"'side' has 1 images", "'ahead' has 3", "time stamp"});
}

TEST_F(RigSourceTest, ACameraWithoutImages) {
  Write("rig.yaml", OwnRig(kSidePose));
  WriteImage("ahead/0.png");
  ExpectRefusal(ErrorCode::kBadSource, {"no images of camera 'side'", "remove the camera"});
}

TEST_F(RigSourceTest, TimeStampsPairWhatBelongsTogether) {
  Write("rig.yaml", OwnRig(kSidePose));
  // The second camera misses the second moment and is 5 ms late.
  WriteImage("ahead/1700000000000000000.png", 1);
  WriteImage("ahead/1700000000100000000.png", 2);
  WriteImage("ahead/1700000000200000000.png", 3);
  WriteImage("side/1700000000005000000.png", 11);
  WriteImage("side/1700000000205000000.png", 13);
  const RigSequence sequence = Open();
  ASSERT_EQ(sequence.moments.size(), 2u);
  EXPECT_NEAR(*sequence.moments[1].time_s, 1700000000.2, 1e-6);
  EXPECT_EQ(ReadMoment(sequence, sequence.moments[1])[1].at<uchar>(0, 0), 13);
  ExpectError([&] { Open({.rig_file = {}, .max_time_gap_s = 0.001}); }, ErrorCode::kBadSource,
              {"within 0.001", "check the time stamp"});
}

// Of two images as near as each other the first in its folder is taken.
TEST_F(RigSourceTest, TimeStampsThatAreAsNear) {
  Write("rig.yaml", OwnRig(kSidePose));
  WriteImage("ahead/0.5.png");
  WriteImage("ahead/2.5.png");
  for (const char* side : {"0.25", "0.75", "2.375", "2.625"}) {
    WriteImage("side/" + std::string(side) + ".png");
  }
  const RigSequence sequence = Open({.rig_file = {}, .max_time_gap_s = 1});
  ASSERT_EQ(sequence.moments.size(), 2u);
  EXPECT_EQ(sequence.moments[0].images[1].filename(), "0.25.png");
  EXPECT_EQ(sequence.moments[1].images[1].filename(), "2.375.png");
}

TEST_F(RigSourceTest, ManyTimeStampsArePairedAtOnce) {
  constexpr int kMoments = 20'000;
  const Rig rig = ReadRigFile(Write("rig.yaml", OwnRig(kSidePose)));
  CameraImages found{
      .layout = "parallel folders", .cameras = {"ahead", "side"}, .images = {{}, {}}};
  for (int i = 0; i < kMoments; ++i) {
    for (int camera = 0; camera < 2; ++camera) {
      const int64_t time_ns = 1'700'000'000'000'000'000 + 100'000'000LL * i + 1'000'000 * camera;
      const std::string name = std::to_string(time_ns) + ".png";
      found.images[camera].push_back({name, name});
    }
  }
  const auto start = std::chrono::steady_clock::now();
  const std::vector<RigMoment> moments = GroupMoments(found, rig, folder_, 0.02);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
  ASSERT_EQ(moments.size(), static_cast<size_t>(kMoments));
  EXPECT_EQ(moments[777].images[1], found.images[1][777].path);
}

TEST_F(RigSourceTest, NumberedFoldersOfFacesNeedNoFile) {
  for (const char* moment : {"rig/000", "rig/001"}) {
    for (const char* face : kFaces) {
      WriteImage(std::string(moment) + "/" + face + ".jpg", 50, {32, 32});
    }
  }
  const RigSequence sequence = Open();
  EXPECT_EQ(sequence.layout, "numbered folders");
  EXPECT_EQ(sequence.rig.cameras.size(), 6u);
  EXPECT_EQ(sequence.rig.cameras[0].camera.params[0], 16);
  ASSERT_EQ(sequence.moments.size(), 2u);
  EXPECT_EQ(sequence.moments[1].source, "001");
  const RigSequence one = OpenRigSequence(folder_ / "rig/001");
  EXPECT_EQ(one.layout, "one moment");
  EXPECT_EQ(one.moments.size(), 1u);
  std::filesystem::remove(folder_ / "rig/001/left.jpg");
  ExpectRefusal(ErrorCode::kBadSource, {"001", "no image of camera 'left'"});
}

TEST_F(RigSourceTest, ImagesOfAnotherSize) {
  for (const char* face : kFaces) WriteImage(std::string(face) + ".jpg", 50, {32, 32});
  WriteImage("right.jpg", 50, {40, 32});
  const RigSequence sequence = Open();
  ExpectError([&] { ReadMoment(sequence, sequence.moments[0]); }, ErrorCode::kBadImage,
              {"right.jpg", "40x32", "32x32"});
}

TEST_F(RigSourceTest, OnePinholeIsARigOfOne) {
  Write("camera.yaml",
        "camera_model: PINHOLE\nimage_width: 16\nimage_height: 12\nfx: 10\nfy: 10\ncx: 7\ncy: 5\n");
  WriteImage("images/a.png", 7);
  const RigSequence sequence = Open();
  EXPECT_EQ(sequence.layout, "images");
  EXPECT_EQ(sequence.rig.cameras.size(), 1u);
  EXPECT_EQ(OpenRigSequence(folder_ / "images").moments.size(), 1u);
  EXPECT_EQ(OpenRigSequence(folder_ / "images/a.png").moments.size(), 1u);
  // An image that is named from its own folder.
  const std::filesystem::path here = std::filesystem::current_path();
  std::filesystem::copy(folder_ / "camera.yaml", folder_ / "images");
  std::filesystem::current_path(folder_ / "images");
  EXPECT_NO_THROW(EXPECT_EQ(OpenRigSequence("a.png").moments.size(), 1u));
  std::filesystem::current_path(here);
}

TEST_F(RigSourceTest, WithoutCalibration) {
  WriteImage("a.png");
  ExpectRefusal(ErrorCode::kBadSource, {"has no calibration", "--camera"});
  ExpectError([&] { OpenRigSequence(folder_ / "nowhere"); }, ErrorCode::kBadSource,
              {"does not exist"});
}

TEST_F(RigSourceTest, EmptyFolder) { ExpectRefusal(ErrorCode::kBadSource, {"no rig images"}); }

// A panorama whose grey value tells the azimuth: each face shows its own part, the back face also
// across the seam.
TEST_F(RigSourceTest, PanoramaBecomesFaces) {
  cv::Mat panorama(64, 128, CV_8UC1);
  for (int x = 0; x < 128; ++x) panorama.col(x).setTo(std::abs(2 * x - 127));
  const auto faces = FacesOfPanorama(panorama, 33);
  ASSERT_EQ(faces.size(), 6u);
  EXPECT_NEAR(faces[0].at<uchar>(16, 16), 0, 2);
  EXPECT_NEAR(faces[1].at<uchar>(16, 16), 64, 2);
  EXPECT_NEAR(faces[2].at<uchar>(16, 16), 127, 2);
  EXPECT_NEAR(faces[3].at<uchar>(16, 16), 64, 2);
  EXPECT_LT(faces[0].at<uchar>(16, 5), faces[0].at<uchar>(16, 1));
  ASSERT_TRUE(cv::imwrite((folder_ / "p.png").string(), panorama));
  const RigSequence sequence = Open();
  EXPECT_EQ(sequence.layout, "panoramas");
  EXPECT_EQ(ReadMoment(sequence, sequence.moments[0]).size(), 6u);
}

}  // namespace
}  // namespace waystone
