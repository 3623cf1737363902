// SPDX-License-Identifier: Apache-2.0
#include <cstring>

#include "tests/builder/sources/temporary_folder.h"

namespace waystone {
namespace {

class CameraFileTest : public TemporaryFolder {
 protected:
  Camera Read(const std::string& text) { return ReadCameraFile(Write("camera.yaml", text)); }

  void ExpectRefusal(const std::string& text, const std::vector<std::string>& parts) {
    std::vector<std::string> all = parts;
    all.emplace_back("camera.yaml");
    ExpectError([&] { Read(text); }, ErrorCode::kBadCamera, all);
  }
};

constexpr const char* kOpenCvFile = R"(%YAML:1.0
---
calibration_time: "Tue 02 Jan 2024 10:00:00"
image_width: 640
image_height: 480
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 5.1e+02, 0., 3.195e+02, 0., 5.2e+02,
       2.395e+02, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ 1.0e-01, -2.0e-01, 1.0e-03, 2.0e-03, 3.0e-02 ]
)";

TEST_F(CameraFileTest, OpenCv) {
  EXPECT_EQ(Read(kOpenCvFile),
            (Camera{CameraModel::kFullOpenCv,
                    640,
                    480,
                    {510, 520, 319.5, 239.5, 0.1, -0.2, 0.001, 0.002, 0.03, 0, 0, 0}}));
}

// What stands between the two, K with D, is the same in all of them.
std::string OpenCvWith(const std::string& rest) {
  return "%YAML:1.0\nimage_Width: 64\nimage_Height: 48\n"
         "Camera_Matrix: !!opencv-matrix\n  rows: 3\n  cols: 3\n  dt: d\n"
         "  data: [50, 0, 31, 0, 51, 23, 0, 0, 1]\n" +
         rest;
}

TEST_F(CameraFileTest, NumberOfCoefficientsGivesTheModel) {
  const auto model_of = [&](const std::string& list) {
    return Read(OpenCvWith("distortion_coefficients: " + list + "\n")).model;
  };
  EXPECT_EQ(Read(OpenCvWith("")).model, CameraModel::kPinhole);
  EXPECT_EQ(model_of("[]"), CameraModel::kPinhole);
  EXPECT_EQ(model_of("[1, 2, 3, 4]"), CameraModel::kOpenCv);
  EXPECT_EQ(model_of("[1, 2, 3, 4, 5]"), CameraModel::kFullOpenCv);
  EXPECT_EQ(model_of("[1, 2, 3, 4, 5, 6, 7, 8]"), CameraModel::kFullOpenCv);
  EXPECT_EQ(model_of("[1, 2, 3, 4, 5, 6, 7, 8, 0, 0, 0, 0]"), CameraModel::kFullOpenCv);
  ExpectRefusal(OpenCvWith("distortion_coefficients: [1, 2, 3]\n"),
                {"3 distortion", "must be 0, 4"});
  ExpectRefusal(OpenCvWith("distortion_coefficients: [1, 2, 3, 4, 5, 6, 7, 8, 9, 0, 0, 0]\n"),
                {"12 distortion", "thin-prism"});
  const Camera full = Read(OpenCvWith("dist_coeffs: [1, 2, 3, 4, 5, 6, 7, 8]\n"));
  EXPECT_EQ(std::vector<double>(full.params.begin() + 4, full.params.end()),
            (std::vector<double>{1, 2, 3, 4, 5, 6, 7, 8}));
}

TEST_F(CameraFileTest, OpenCvFisheye) {
  const Camera camera =
      Read(OpenCvWith("fisheye_model: 1\nDistortion_Coefficients: [0.1, 0.2, 0.3, 0.4]\n"));
  EXPECT_EQ(camera,
            (Camera{CameraModel::kOpenCvFisheye, 64, 48, {50, 51, 31, 23, 0.1, 0.2, 0.3, 0.4}}));
  ExpectRefusal(OpenCvWith("fisheye_model: 1\ndistortion_coefficients: [0, 0, 0, 0, 0]\n"),
                {"5 distortion", "fisheye model has 4"});
}

constexpr const char* kRosStart = R"(image_width: 640
image_height: 480
camera_name: head
camera_matrix:
  rows: 3
  cols: 3
  data: [510, 0, 319.5, 0, 520, 239.5, 0, 0, 1]
)";

TEST_F(CameraFileTest, RosCameraInfo) {
  const std::string coefficients =
      "distortion_coefficients:\n  rows: 1\n  cols: 4\n  data: [0.1, 0.2, 0.3, 0.4]\n";
  const std::string start = kRosStart;
  EXPECT_EQ(Read(start + "distortion_model: plumb_bob\n" + coefficients).model,
            CameraModel::kOpenCv);
  EXPECT_EQ(Read(start + "distortion_model: equidistant\n" + coefficients).model,
            CameraModel::kOpenCvFisheye);
  ExpectRefusal(start + "distortion_model: magic_mirror\n" + coefficients,
                {"'magic_mirror'", "plumb_bob"});
}

TEST_F(CameraFileTest, RosMessages) {
  const Camera expected = {CameraModel::kOpenCv, 64, 48, {50, 51, 31, 23, 0.1, 0, 0, 0}};
  EXPECT_EQ(Read("height: 48\nwidth: 64\ndistortion_model: \"plumb_bob\"\nD: [0.1, 0.0, 0.0, 0]\n"
                 "K: [50.0, 0.0, 31.0, 0.0, 51.0, 23.0, 0.0, 0.0, 1.0]\n"),
            expected);
  EXPECT_EQ(Read("height: 48\nwidth: 64\ndistortion_model: plumb_bob\nd:\n- 0.1\n- 0\n- 0\n- 0\n"
                 "k: [50.0, 0.0, 31.0, 0.0, 51.0, 23.0, 0.0, 0.0, 1.0]\n---\n"),
            expected);
}

std::string Kalibr(const std::string& model, const std::string& distortion) {
  return "cam0:\n  cam_overlaps: [1]\n  camera_model: " + model +
         "\n  distortion_coeffs: [0.1, 0.2, 0.3, 0.4]\n  distortion_model: " + distortion +
         "\n  intrinsics: [50, 51, 31, 23]\n  resolution: [64, 48]\n  rostopic: /cam0/image\n"
         "cam1:\n  camera_model: pinhole\n";
}

TEST_F(CameraFileTest, KalibrsFirstCamera) {
  EXPECT_EQ(Read(Kalibr("pinhole", "radtan")),
            (Camera{CameraModel::kOpenCv, 64, 48, {50, 51, 31, 23, 0.1, 0.2, 0.3, 0.4}}));
  EXPECT_EQ(Read(Kalibr("pinhole", "equidistant")).model, CameraModel::kOpenCvFisheye);
  ExpectRefusal(Kalibr("omni", "radtan"), {"'omni'", "calibrate with pinhole"});
  ExpectRefusal(Kalibr("ds", "none"), {"'ds'"});
  ExpectRefusal(Kalibr("pinhole", "fov"), {"'fov'"});
  ExpectRefusal("cam0: 5\n", {"camera_model"});
  for (const auto& [side, part] :
       {std::pair{".nan", "not a number"}, {"-5", "0x48 pixels"}, {"1e300", "each side"}}) {
    std::string text = Kalibr("pinhole", "radtan");
    text.replace(text.find("[64,"), 3, std::string("[") + side);
    ExpectRefusal(text, {part});
  }
}

TEST_F(CameraFileTest, OwnKeys) {
  EXPECT_EQ(Read("camera_model: PINHOLE\nimage_width: 640\nimage_height: 480\n"
                 "fx: 515\nfy: 516\ncx: 320\ncy: 240\n# a comment\n"),
            (Camera{CameraModel::kPinhole, 640, 480, {515, 516, 320, 240}}));
  EXPECT_EQ(Read("{camera_model: SIMPLE_RADIAL, image_width: 640, image_height: 480, "
                 "fx: 515, fy: 515, cx: 320, cy: 240, k1: -0.1}"),
            (Camera{CameraModel::kSimpleRadial, 640, 480, {515, 320, 240, -0.1}}));
  EXPECT_EQ(Read("camera_model: EQUIRECTANGULAR\nimage_width: 1024\nimage_height: 512\n"),
            (Camera{CameraModel::kEquirectangular, 1024, 512, {}}));
}

TEST_F(CameraFileTest, OwnKeysThatAreWrong) {
  const std::string size = "image_width: 640\nimage_height: 480\n";
  ExpectRefusal("camera_model: PINHOLE\n" + size + "fx: 515\ncx: 320\ncy: 240\n",
                {"fy is missing", "add it"});
  ExpectRefusal("camera_model: PINHOLE\nimage_width: 640.5\nfx: 1\n", {"image_width"});
  ExpectRefusal("camera_model: LENSLESS\n" + size, {"'LENSLESS'", "a COLMAP model name"});
  ExpectRefusal("camera_model: PINHOLE\n" + size + "fx: wide\nfy: 1\ncx: 3\ncy: 2\n",
                {"fx must be a number"});
  ExpectRefusal("camera_model: PINHOLE\n" + size + "fx: 9\nfy: 9\ncx: 3\ncy: 2\nk1: 0.3\n",
                {"k1 is not a parameter of PINHOLE"});
  ExpectRefusal("camera_model: PINHOLE\n" + size + "fx: -9\nfy: 9\ncx: 3\ncy: 2\n",
                {"parameter 1", "from 1e-6 to 1e9"});
  // Pixels would be infinite.
  ExpectRefusal("1 SIMPLE_RADIAL 640 480 500.5 320 240 0.1e308\n",
                {"parameter 4", "from -1e9 to 1e9"});
  ExpectRefusal(
      "camera_model: PINHOLE\nimage_width: 0\nimage_height: 480\n"
      "fx: 9\nfy: 9\ncx: 3\ncy: 2\n",
      {"0x480"});
}

TEST_F(CameraFileTest, ColmapHasItsCentreHalfAPixelOn) {
  EXPECT_EQ(Read("# Camera list\n# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n"
                 "1 OPENCV 640 480 515 516 320 240.5 0.1 0.2 0.3 0.4\n"),
            (Camera{CameraModel::kOpenCv, 640, 480, {515, 516, 319.5, 240, 0.1, 0.2, 0.3, 0.4}}));
  EXPECT_EQ(Read("7 SIMPLE_RADIAL 640 480 515 320 240 -0.1\n").params,
            (std::vector<double>{515, 319.5, 239.5, -0.1}));
}

TEST_F(CameraFileTest, AByteOrderMarkIsNoPartOfTheFile) {
  const std::string mark = "\xef\xbb\xbf";
  EXPECT_EQ(Read(mark + kOpenCvFile), Read(kOpenCvFile));
  const std::string colmap = "7 SIMPLE_RADIAL 640 480 515 320 240 -0.1\n";
  EXPECT_EQ(Read(mark + colmap), Read(colmap));
}

TEST_F(CameraFileTest, ColmapsErrorsNameTheLine) {
  ExpectRefusal("1 PINHOLE 640 480 515 516 320 240\n2 PINHOLE 640 480 515 516 320 240\n",
                {"line 2", "2 cameras"});
  ExpectRefusal("# one\n1 FOV 640 480 515 516 320 240 0.9\n", {"line 2", "FOV"});
  ExpectRefusal("1 PINHOLE 640 480 515 516 320\n", {"line 1", "has 4 parameters", "not 3"});
  ExpectRefusal("1 PINHOLE 640 480 515 516 320 y\n", {"line 1", "'y'"});
  ExpectRefusal("1 PINHOLE wide 480 515 516 320 240\n", {"line 1", "width"});
}

TEST_F(CameraFileTest, OtherFilesAreRefused) {
  ExpectRefusal("", {"no keys"});
  ExpectRefusal("just a sentence", {"no keys"});
  ExpectRefusal("a: 1\nb: 2\n", {"a b", "no supported format"});
  ExpectRefusal("a: [1\nb: }\n", {"line 2", "not valid YAML"});
  ExpectRefusal("%YAML:1.0\n---\na: 1\n- b\n", {"line 4", "not valid YAML"});
  ExpectRefusal("<?xml version=\"1.0\"?>\n<opencv_storage/>\n", {"XML", "as YAML"});
  ExpectRefusal(std::string(5000, '['), {"not valid YAML"});
  ExpectRefusal(std::string("\xff\xd8\xff\x00\x01\x02", 6), {});
  ExpectRefusal(OpenCvWith("").replace(10, 11, "image_Girth"), {"image_width is missing"});
  ExpectError([&] { ReadCameraFile(folder_ / "none.yaml"); }, ErrorCode::kBadCamera,
              {"none.yaml", "does not exist"});
  ExpectError([&] { ReadCameraFile(folder_); }, ErrorCode::kBadCamera, {"is not a regular file"});
}

TEST_F(CameraFileTest, MatricesThatAreWrong) {
  ExpectRefusal("image_width: 64\nimage_height: 48\ncamera_matrix: [1, 2, 3]\n",
                {"camera_matrix has 3 numbers, not 9"});
  ExpectRefusal("image_width: 64\nimage_height: 48\ncamera_matrix: large\n", {"must be a list"});
  ExpectRefusal("image_width: 64\nimage_height: 48\ncamera_matrix: [50, 1, 3, 0, 5, 6, 0, 0, 1]\n",
                {"skew"});
  ExpectRefusal("image_width: 64\nimage_height: 48\ncamera_matrix: [50, x, 3, 0, 5, 6, 0, 0, 1]\n",
                {"position 2"});
}

template <class Value>
std::string Binary(const Value& value) {
  std::string bytes(sizeof(value), '\0');
  std::memcpy(bytes.data(), &value, sizeof(value));
  return bytes;
}

// COLMAP's cameras.bin with `count` cameras of a model.
std::string ColmapCameras(uint64_t count, int32_t model, const std::vector<double>& parameters) {
  std::string bytes = Binary(count);
  for (uint64_t i = 0; i < count; ++i) {
    bytes += Binary(uint32_t{7}) + Binary(model) + Binary(uint64_t{640}) + Binary(uint64_t{480});
    for (const double parameter : parameters) bytes += Binary(parameter);
  }
  return bytes;
}

TEST_F(CameraFileTest, ColmapBinary) {
  const auto read = [&](const std::string& bytes) {
    return ReadCameraFile(Write("cameras.bin", bytes));
  };
  const std::string sound = ColmapCameras(1, 2, {515, 320, 240, 0.1});
  EXPECT_EQ(read(sound), (Camera{CameraModel::kSimpleRadial, 640, 480, {515, 319.5, 239.5, 0.1}}));
  for (size_t bytes = 0; bytes < sound.size(); ++bytes) {
    ExpectError([&] { read(sound.substr(0, bytes)); }, ErrorCode::kBadCamera,
                {"cameras.bin", "isn't COLMAP's"});
  }
  ExpectError(
      [&] {
        read(ColmapCameras(2, 2, {515, 320, 240, 0.1}));
      },
      ErrorCode::kBadCamera, {"cameras.bin", "2 cameras"});
  ExpectError(
      [&] {
        read(ColmapCameras(1, 7, {1, 2, 3, 4, 5}));
      },
      ErrorCode::kBadCamera, {"with number 7 is not supported"});
  ExpectError(
      [&] {
        read(ColmapCameras(1, 0, {-1, 320, 240}));
      },
      ErrorCode::kBadCamera, {"cameras.bin"});
}

}  // namespace
}  // namespace waystone
