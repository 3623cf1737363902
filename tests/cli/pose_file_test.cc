// SPDX-License-Identifier: Apache-2.0
#include "cli/files/pose_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "cli/files/given_poses.h"
#include "cli/files/image_poses.h"
#include "core/base/error.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

class PoseFileTest : public testing::Test {
 protected:
  PoseFileTest() : folder_(fs::temp_directory_path() / fs::path(Name())) {
    fs::create_directories(folder_);
  }
  ~PoseFileTest() override { fs::remove_all(folder_); }

  static std::string Name() {
    return std::string("waystone_poses_") +
           testing::UnitTest::GetInstance()->current_test_info()->name();
  }
  fs::path Write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }
  static std::string RefusalOf(const std::function<void()>& run) {
    try {
      run();
    } catch (const MapError& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder_;
};

// A camera at (1, 2, 3) that is turned by 90 degrees about z: q = (0, 0, s, s), s = sqrt(1/2).
const std::string kHalf = "0.70710678118654752";

void ExpectThePose(const FilePose& pose) {
  EXPECT_TRUE(pose.pose.has_rotation);
  const Eigen::Isometry3d& at = pose.pose.world_from_camera;
  EXPECT_NEAR((at.translation() - Eigen::Vector3d(1, 2, 3)).norm(), 0, 1e-9);
  EXPECT_NEAR((at * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(1, 3, 3)).norm(), 0, 1e-9);
}

template <class Value>
std::string Binary(const Value& value) {
  std::string bytes(sizeof(value), '\0');
  std::memcpy(bytes.data(), &value, sizeof(value));
  return bytes;
}

// The same pose as COLMAP has it: x_camera = R(q)^T (x - (1, 2, 3)).
std::string ColmapImages(uint64_t points) {
  const double half = std::sqrt(0.5);
  std::string bytes = Binary(uint64_t{1}) + Binary(uint32_t{7});
  for (const double value : {half, 0.0, 0.0, -half, -2.0, 1.0, -3.0}) bytes += Binary(value);
  bytes += Binary(uint32_t{1}) + "left/a.jpg" + std::string(1, '\0') + Binary(points);
  return bytes + std::string(24 * points, 'x');
}

TEST_F(PoseFileTest, ReadsEachFormat) {
  const auto tum = ReadPoseFile(Write("t.txt", "# c\n1.5 1 2 3 0 0 " + kHalf + " " + kHalf + "\n"));
  ASSERT_EQ(tum.size(), 1u);
  ExpectThePose(tum[0]);
  EXPECT_EQ(tum[0].time_s, 1.5);
  ExpectThePose(ReadPoseFile(Write("k.txt", "0 -1 0 1 1 0 0 2 0 0 1 3\n"))[0]);
  const auto euroc = ReadPoseFile(Write("e.csv", "#timestamp, p_RS_R_x [m]\n1500000000, 1,2,3," +
                                                     kHalf + ",0,0," + kHalf + ",9,9\n"));
  ExpectThePose(euroc[0]);
  EXPECT_NEAR(*euroc[0].time_s, 1.5, 1e-9);
  const auto g2o =
      ReadPoseFile(Write("g.g2o", "FIX 0\nVERTEX_SE3:QUAT 12 1 2 3 0 0 " + kHalf + " " + kHalf +
                                      "\nEDGE_SE3:QUAT 0 1 1 0 0 0 0 0 1\n"));
  ASSERT_EQ(g2o.size(), 1u);
  ExpectThePose(g2o[0]);
  EXPECT_EQ(g2o[0].number, 12);
  const auto colmap = ReadPoseFile(Write("images.bin", ColmapImages(2)));
  ASSERT_EQ(colmap.size(), 1u);
  ExpectThePose(colmap[0]);
  EXPECT_EQ(colmap[0].name, "left/a.jpg");
}

// As spreadsheets and some editors write it.
TEST_F(PoseFileTest, AByteOrderMarkIsNoPartOfTheFile) {
  const std::string mark = "\xef\xbb\xbf";
  const std::string pose = "1,2,3,0,0," + kHalf + "," + kHalf + "\n";
  const auto csv = ReadPoseFile(Write("p.csv", mark + "image,x,y,z,qx,qy,qz,qw\nb.jpg," + pose));
  ExpectThePose(csv[0]);
  EXPECT_EQ(csv[0].name, "b.jpg");
  const auto euroc =
      ReadPoseFile(Write("e.csv", mark + "#timestamp, p_RS_R_x [m]\n1500000000,1,2,3," + kHalf +
                                      ",0,0," + kHalf + "\n"));
  EXPECT_NEAR(euroc[0].time_s.value(), 1.5, 1e-9);
  const auto echo = ReadPoseFile(Write("o.csv", mark + "2,500000000,odom,base_link," + pose));
  EXPECT_NEAR(echo[0].time_s.value(), 2.5, 1e-9);
  const auto tum = ReadPoseFile(Write("t.txt", mark + "1.5 1 2 3 0 0 " + kHalf + " " + kHalf));
  EXPECT_EQ(tum[0].time_s, 1.5);
}

TEST_F(PoseFileTest, ACsvMustSayWhichImagesItsPosesBelongTo) {
  const std::string refusal =
      RefusalOf([&] { ReadPoseFile(Write("p.csv", "picture,x,y,z\nb.jpg,1,2,3\n")); });
  for (const char* name : {"line 1", "image", "keyframe", "id", "frame", "time_s"}) {
    EXPECT_NE(refusal.find(name), std::string::npos) << name << ": " << refusal;
  }
  for (const char* name : {"image", "keyframe", "id", "frame", "time_s"}) {
    const std::string text = std::string(name) + ",x,y,z\n7,1,2,3\n";
    EXPECT_EQ(ReadPoseFile(Write("p.csv", text)).size(), 1u) << name;
  }
}

// nav_msgs/Odometry as the tools of ROS 1 and 2 and of bags write it.
TEST_F(PoseFileTest, ReadsOdometry) {
  const std::string pose = "1,2,3,0,0," + kHalf + "," + kHalf;
  const std::string fields =
      "pose.pose.position.x,P.pose.pose.position.y,P.pose.pose.position.z,P.pose.pose.orientation."
      "x,"
      "P.pose.pose.orientation.y,P.pose.pose.orientation.z,P.pose.pose.orientation.w";
  std::string ros1 = "%time,field.header.seq,field.header.stamp,field.header.frame_id,P." + fields;
  for (size_t at = 0; (at = ros1.find("P.", at)) != std::string::npos;)
    ros1.replace(at, 2, "field.");
  std::string bag = "Time,header.stamp.secs,header.stamp.nsecs,header.frame_id,P." + fields;
  for (size_t at = 0; (at = bag.find("P.", at)) != std::string::npos;) bag.replace(at, 2, "");
  const std::string texts[] = {
      ros1 + ",twist\n9,1,2500000000,odom," + pose + ",7\n9,1,2600000000,," + pose + ",7\n",
      bag + "\r\n9,2,500000000,odom," + pose + "\r\n9,2,600000000,," + pose + "\r\n",
      "2,500000000,odom,base_link," + pose + ",0,0\n2,600000000,odom,base_link," + pose + ",0,0\n"};
  for (const std::string& text : texts) {
    const auto poses = ReadPoseFile(Write("odometry.csv", text));
    ASSERT_EQ(poses.size(), 2U) << text;
    ExpectThePose(poses[0]);
    EXPECT_NEAR(*poses[0].time_s, 2.5, 1e-9) << text;
    EXPECT_NEAR(*poses[1].time_s, 2.6, 1e-9) << text;
  }
  const std::string cut = texts[2] + "3,1,odom,base_link,1,2\n";
  EXPECT_NE(
      RefusalOf([&] { ReadPoseFile(Write("cut.csv", cut)); }).find("line 3: not a row of nav"),
      std::string::npos);
  const std::string words = texts[2] + "3,1,odom,base_link,1,2,x,0,0,0,1,0,0\n";
  EXPECT_NE(RefusalOf([&] { ReadPoseFile(Write("words.csv", words)); }).find("line 3"),
            std::string::npos);
}

TEST_F(PoseFileTest, RefusesABinaryModelThatIsCut) {
  const std::string whole = ColmapImages(2);
  for (size_t bytes = 0; bytes < whole.size(); bytes += 5) {
    const fs::path path = Write("images.bin", whole.substr(0, bytes));
    EXPECT_NE(RefusalOf([&] { ReadPoseFile(path); }).find("isn't COLMAP's images.bin"),
              std::string::npos);
  }
}

// A video's frames have no extension; the images that another program saw have.
TEST_F(PoseFileTest, FindsNamesWithoutTheirExtension) {
  const std::string line = " 1 0 0 0 0 0 0 1 ";
  const fs::path path =
      Write("images.txt", "1" + line + "walk/frame 12.jpg\n\n2" + line + "walk/b.x\n\n");
  const ImagePoses poses(ReadPoseFile(path), 0.2);
  EXPECT_TRUE(poses.Find("walk.mp4/walk/frame 12", {}, 0));
  EXPECT_TRUE(poses.Find("walk/frame 12.jpg", {}, 0));
  EXPECT_TRUE(poses.Find("walk/b", {}, 0));
  EXPECT_FALSE(poses.Find("walk/frame 1", {}, 0));
}

// The pose of ColmapImages with its quaternion scaled and its position moved.
std::string ColmapImagesWith(double scale, double x) {
  std::string bytes = ColmapImages(0);
  const double half = scale * std::sqrt(0.5);
  const double values[] = {half, 0, 0, -half, x};
  std::memcpy(bytes.data() + sizeof(uint64_t) + sizeof(uint32_t), values, sizeof(values));
  return bytes;
}

TEST_F(PoseFileTest, ABinaryModelsPoseIsOneOrRefused) {
  const auto read = [&](double quaternion_scale, double x) {
    return ReadPoseFile(Write("images.bin", ColmapImagesWith(quaternion_scale, x)));
  };
  ExpectThePose(read(1, -2)[0]);
  ExpectThePose(read(1e-160, -2)[0]);
  EXPECT_TRUE(read(1e-315, -2)[0].pose.world_from_camera.linear().isUnitary(1e-9));
  ExpectThePose(read(1e160, -2)[0]);
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  using Bad = std::pair<double, double>;
  for (const Bad& bad :
       {Bad(0, -2), Bad(kInfinite, -2), Bad(std::nan(""), -2), Bad(1, kInfinite), Bad(1, 1e13)}) {
    const std::string refusal = RefusalOf([&] { read(bad.first, bad.second); });
    EXPECT_NE(refusal.find("has a pose that is no pose"), std::string::npos)
        << bad.first << " " << bad.second << ": " << refusal;
  }
}

TEST_F(PoseFileTest, ALineThatIsNoPoseIsNamed) {
  using File = std::pair<std::string, std::string>;  // name, header and first line
  const auto refusal = [&](const File& file, const std::string& line) {
    return RefusalOf([&] { ReadPoseFile(Write(file.first, file.second + line + "\n")); });
  };
  const File tum{"t.txt", "0 1 2 3 0 0 0 1\n"};
  const File kitti{"k.txt", "0 -1 0 1 1 0 0 2 0 0 1 3\n"};
  const File csv{"p.csv", "image,x,y,z,qx,qy,qz,qw\n"};
  const File euroc{"e.csv", "#timestamp,x,y,z,qw,qx,qy,qz\n"};
  const File g2o{"g.g2o", "VERTEX_SE3:QUAT 0 1 2 3 0 0 0 1\n"};
  using Bad = std::pair<File, std::string>;
  for (const auto& [file, line] :
       {Bad(tum, "1 1 2 3 0 0 0 0"), Bad(tum, "1 1e300 2 3 0 0 0 1"), Bad(tum, "1 nan 2 3 0 0 0 1"),
        Bad(kitti, "0 0 0 1 0 0 0 2 0 0 0 3"), Bad(kitti, "-1 0 0 1 0 1 0 2 0 0 1 3"),
        Bad(csv, "a,1,2,3,0,0,0,0"), Bad(csv, "a,1e13,2,3,0,0,0,1"), Bad(csv, "a,1,2,3,0,0,0,inf"),
        Bad(euroc, "1,1,2,3,0,0,0,0"), Bad(g2o, "VERTEX_SE3:QUAT 1 1 2 3 0 0 0 0")}) {
    EXPECT_NE(refusal(file, line).find("line 2: "), std::string::npos)
        << line << ": " << refusal(file, line);
  }
  EXPECT_EQ(refusal(tum, "1 4e6 5e5 3 0 0 0 2"), "");
}

// COLMAP writes a line of points after each image; without it, every second image would be lost.
TEST_F(PoseFileTest, ColmapsPointsAreThere) {
  const auto refusal = [&](const std::string& text) {
    return RefusalOf([&] { ReadPoseFile(Write("images.txt", text)); });
  };
  const std::string a = "1 1 0 0 0 0 0 0 1 a.jpg\n", b = "2 1 0 0 0 0 0 0 1 b.jpg\n";
  EXPECT_EQ(refusal("# c\n" + a + "1.5 2 -1 3 4.5 7\n" + b), "");
  EXPECT_EQ(ReadPoseFile(folder_ / "images.txt").size(), 2u);
  EXPECT_NE(refusal("# c\n" + a + b).find("images.txt, line 3: not the points"), std::string::npos)
      << refusal("# c\n" + a + b);
  EXPECT_NE(refusal(a + "1.5 2 -1 3\n").find("line 2: not the points"), std::string::npos);
}

TEST_F(PoseFileTest, ALineOfNumbersIsNoImageOfColmap) {
  for (const char* line : {"0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15", "1 1 0 0 0 0 0 0 1 7",
                           "0.5 1 0 0 0 0 0 0 1 a.jpg", "1 1 0 0 0 0 0 0 1.5 a.jpg"}) {
    const std::string refusal = RefusalOf([&] { ReadPoseFile(Write("p.txt", line)); });
    EXPECT_NE(refusal.find("line 1: not a pose; expected"), std::string::npos) << refusal;
  }
}

FilePose PoseAt(double time_s, double x, double turn_rad) {
  FilePose pose;
  pose.time_s = time_s;
  pose.pose.has_rotation = true;
  pose.pose.world_from_camera.translation().x() = x;
  pose.pose.world_from_camera.linear() =
      Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return pose;
}

TEST(ImagePoses, AreInterpolatedBetweenNearTimesAlone) {
  const ImagePoses poses({PoseAt(2, 5, 0.4), PoseAt(1, 1, 0), PoseAt(1.1, 2, 0.2)}, 0.15);
  const auto between = poses.Find("a", 1.025, 0);
  ASSERT_TRUE(between);
  EXPECT_NEAR(between->world_from_camera.translation().x(), 1.25, 1e-9);
  EXPECT_NEAR(Eigen::AngleAxisd(between->world_from_camera.linear()).angle(), 0.05, 1e-9);
  EXPECT_FALSE(poses.Find("a", 1.5, 0));  // 0.9 s between its neighbours
  EXPECT_TRUE(poses.Find("a", 1.99, 0));  // 10 ms off
  EXPECT_FALSE(poses.Find("a", 2.05, 0));
  EXPECT_FALSE(poses.Find("a", 0.9, 0));
}

TEST(ImagePoses, AreFoundByNameOrNumber) {
  FilePose named = PoseAt(0, 3, 0);
  named.time_s.reset();
  named.name = "b.jpg";
  const ImagePoses by_name({named});
  EXPECT_TRUE(by_name.Find("walk/images/b.jpg", 1.0, 0));
  EXPECT_FALSE(by_name.Find("walk/c.jpg", 1.0, 0));
  EXPECT_FALSE(by_name.AreNumbered());
  FilePose numbered = PoseAt(0, 4, 0);
  numbered.time_s.reset();
  numbered.number = 8;
  const ImagePoses by_number({numbered});
  EXPECT_TRUE(by_number.AreNumbered());
  EXPECT_TRUE(by_number.Find("x", std::nullopt, 8));
  EXPECT_TRUE(by_number.Find("x", 2.0, 8));  // images have times, poses haven't
  EXPECT_FALSE(by_number.Find("x", std::nullopt, 7));
}

// As `waystone demo` writes it: images with a number have that frame's pose, others that of their
// time.
TEST_F(PoseFileTest, FrameNumbersGoBeforeTimes) {
  const ImagePoses poses(
      ReadPoseFile(Write("p.csv", "frame,time_s,x,y,z\n0,0,0,0,0\n4,0.8,4,0,0\n22,4.4,22,0,0\n")));
  EXPECT_TRUE(poses.AreNumbered());
  const auto x_of = [&](std::optional<double> time_s, std::optional<int> number) {
    const auto pose = poses.Find("a", time_s, number);
    return pose ? pose->world_from_camera.translation().x() : -1;
  };
  EXPECT_EQ(x_of(0.8, 22), 22);
  EXPECT_EQ(x_of(4.4, std::nullopt), 22);
  EXPECT_EQ(x_of(4.4, 3), -1);
  EXPECT_EQ(x_of(std::nullopt, std::nullopt), -1);
  EXPECT_EQ(ReadPoseFile(Write("p.csv", "frame,time_s,x,y,z\n7,,1,2,3\n"))[0].number, 7);
}

TEST_F(PoseFileTest, GivenPosesAreTheCameras) {
  PoseFlags flags{.file = Write("t.txt", "0 1 2 3 0 0 " + kHalf + " " + kHalf + "\n").string(),
                  .frame = "hall",
                  .unit = "metres",
                  .body_from_camera = "0.5 0 0 0 0 0 1"};
  const GivenPoses given = ReadGivenPoses(flags, 1);
  EXPECT_EQ(given.frame, "hall");
  EXPECT_EQ(given.unit, LengthUnit::kMetres);
  FrameInfo image;
  image.time_s = 0.001;
  const auto pose = given.of_image({}, image);
  ASSERT_TRUE(pose);
  EXPECT_NEAR((pose->translation() - Eigen::Vector3d(1, 2.5, 3)).norm(), 0, 1e-9);
  image.time_s = 9;
  EXPECT_FALSE(given.of_image({}, image));
}

TEST_F(PoseFileTest, AKnownDistanceGivesTheScale) {
  const fs::path file =
      Write("p.csv", "image,x,y,z,qw,qx,qy,qz\na.jpg,1,2,3,1,0,0,0\nb.jpg,1,2,7,1,0,0,0\n");
  const auto read = [&](const std::vector<std::string>& scale_by) {
    return ReadGivenPoses({.file = file.string(), .scale_by = scale_by}, 1);
  };
  const GivenPoses given = read({"a.jpg", "b.jpg", "2"});
  EXPECT_EQ(given.unit, LengthUnit::kMetres);
  FrameInfo image;
  image.source = "b.jpg";
  EXPECT_NEAR((given.of_image({}, image)->translation() - Eigen::Vector3d(0.5, 1, 3.5)).norm(), 0,
              1e-9);
  EXPECT_EQ(read({}).unit, LengthUnit::kUnknown);
  const auto refusal = [&](const std::vector<std::string>& scale_by) {
    return RefusalOf([&] { read(scale_by); });
  };
  EXPECT_NE(refusal({"a.jpg", "c", "2"}).find("no pose of 'c'"), std::string::npos);
  EXPECT_NE(refusal({"a.jpg", "a.jpg", "2"}).find("at one position"), std::string::npos);
  for (const char* metres : {"0", "-1", "inf", "two"}) {
    EXPECT_NE(refusal({"a.jpg", "b.jpg", metres}).find("not a distance"), std::string::npos)
        << metres;
  }
}

TEST_F(PoseFileTest, PosesInMetresAreNotScaled) {
  PoseFlags flags;
  flags.scale_by = {"a.jpg", "b.jpg", "2"};
  CheckPoseFlags(flags);
  flags.unit = "metres";
  try {
    CheckPoseFlags(flags);
    FAIL();
  } catch (const MapError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUsage);
    EXPECT_NE(std::string(error.what()).find("leave out one of them"), std::string::npos);
  }
  flags.scale_by.clear();
  CheckPoseFlags(flags);
}

TEST_F(PoseFileTest, GivenPosesThatMakeNoSenseAreRefused) {
  const fs::path tum = Write("t.txt", "0 1 2 3 0 0 0 1\n");
  const fs::path kitti = Write("k.txt", "0 -1 0 1 1 0 0 2 0 0 1 3\n");
  const fs::path bare = Write("p.csv", "image,x,y,z\na.jpg,1,2,3\n");
  const auto refusal = [&](const fs::path& file, const std::string& unit, const std::string& body,
                           int sources) {
    return RefusalOf([&] {
      ReadGivenPoses({.file = file.string(), .unit = unit, .body_from_camera = body}, sources);
    });
  };
  EXPECT_EQ(refusal(tum, "metres", "", 2), "");
  EXPECT_NE(refusal(tum, "feet", "", 1).find("metres or unknown"), std::string::npos);
  EXPECT_NE(refusal(tum, "metres", "1 2 3", 1).find("seven numbers"), std::string::npos);
  EXPECT_NE(refusal(tum, "metres", "0 0 0 1 1 1 1", 1).find("seven numbers"), std::string::npos);
  EXPECT_NE(refusal(kitti, "metres", "", 2).find("numbers its poses"), std::string::npos);
  EXPECT_NE(refusal(bare, "metres", "", 1).find("without orientations"), std::string::npos);
}

}  // namespace
}  // namespace waystone
