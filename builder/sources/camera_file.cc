// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>

#include "builder/sources/camera_section.h"
#include "builder/sources/colmap_camera.h"
#include "builder/sources/files.h"
#include "builder/sources/source.h"
#include "core/base/error.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

// Names of the same thing in different formats.
constexpr Names kWidth = {"image_width", "image_Width", "width"};
constexpr Names kHeight = {"image_height", "image_Height", "height"};
constexpr Names kMatrix = {"camera_matrix", "Camera_Matrix", "K", "k"};
constexpr Names kCoefficients = {"distortion_coefficients",
                                 "Distortion_Coefficients",
                                 "distortion_coeffs",
                                 "dist_coeffs",
                                 "D",
                                 "d"};

bool AllZero(const std::vector<double>& numbers, size_t from) {
  return std::all_of(numbers.begin() + std::min(from, numbers.size()), numbers.end(),
                     [](double number) { return number == 0; });
}

// fx fy cx cy and OpenCV's k1 k2 p1 p2 [k3 [k4 k5 k6 ...]] as the model that holds them.
Camera RadialTangential(const CameraSection& file, Camera camera,
                        const std::vector<double>& distortion) {
  constexpr size_t kHeld = 8;
  const size_t count = distortion.size();
  if (count == 0) return camera;
  if (count != 4 && count != 5 && count < kHeld) {
    file.Refuse("there are " + std::to_string(count) +
                " distortion coefficients; there must be 0, 4, 5 or 8");
  }
  if (!AllZero(distortion, kHeld)) {
    file.Refuse("there are " + std::to_string(count) +
                " distortion coefficients, but thin-prism and tilted-sensor models are not "
                "supported; calibrate with at most 8");
  }
  camera.model = count == 4 ? CameraModel::kOpenCv : CameraModel::kFullOpenCv;
  camera.params.insert(camera.params.end(), distortion.begin(),
                       distortion.begin() + std::min(count, kHeld));
  camera.params.resize(ParameterCount(camera.model));  // k4 to k6 are 0 with five coefficients
  return camera;
}

Camera Fisheye(const CameraSection& file, Camera camera, const std::vector<double>& distortion) {
  if (distortion.size() != 4) {
    file.Refuse("there are " + std::to_string(distortion.size()) +
                " distortion coefficients, but a fisheye model has 4");
  }
  camera.model = CameraModel::kOpenCvFisheye;
  camera.params.insert(camera.params.end(), distortion.begin(), distortion.end());
  return camera;
}

// By the distortion's name in ROS, Kalibr and EuRoC.
Camera Distorted(const CameraSection& file, Camera camera, const std::string& kind,
                 const std::vector<double>& distortion) {
  static constexpr std::array<std::string_view, 6> kRadial{
      "", "plumb_bob", "rational_polynomial", "radtan", "radial-tangential", "none"};
  static constexpr std::array<std::string_view, 2> kFisheye{"equidistant", "fisheye"};
  if (std::ranges::find(kRadial, kind) != kRadial.end()) {
    return RadialTangential(file, std::move(camera), distortion);
  }
  if (std::ranges::find(kFisheye, kind) != kFisheye.end()) {
    return Fisheye(file, std::move(camera), distortion);
  }
  file.Refuse("the distortion_model '" + kind +
              "' is not supported; calibrate with plumb_bob (radtan) or equidistant");
}

// OpenCV and ROS: a 3x3 matrix and coefficients.
Camera ReadMatrixCamera(const CameraSection& file) {
  const std::vector<double> k = file.Numbers(kMatrix, 9);
  if (k[1] != 0)
    file.Refuse("the camera matrix has skew, which is not supported; calibrate without it");
  Camera camera{.model = CameraModel::kPinhole,
                .width = file.Size(kWidth),
                .height = file.Size(kHeight),
                .params = {k[0], k[4], k[2], k[5]}};
  std::vector<double> distortion;
  if (file.Has(kCoefficients)) distortion = file.Numbers(kCoefficients);
  const std::string fisheye = file.Text("fisheye_model");  // OpenCV's calibration sample
  const bool is_fisheye = fisheye == "1" || fisheye == "true";
  return Distorted(file, camera, is_fisheye ? "fisheye" : file.Text("distortion_model"),
                   distortion);
}

// Kalibr and EuRoC: a list of intrinsics, a list of coefficients and a resolution.
Camera ReadKalibrCamera(const CameraSection& file) {
  const std::string model = file.Text("camera_model");
  if (model != "pinhole") {
    file.Refuse("the camera_model '" + model + "' is not supported; calibrate with pinhole");
  }
  const std::vector<double> resolution = file.Numbers({"resolution"}, 2);
  std::vector<double> distortion;
  if (file.Has(kCoefficients)) distortion = file.Numbers(kCoefficients);
  const auto side = [](double px) {
    return px > 0 ? static_cast<int>(std::min(px, static_cast<double>(INT32_MAX))) : 0;  // NaN, too
  };
  Camera camera{.model = CameraModel::kPinhole,
                .width = side(resolution[0]),
                .height = side(resolution[1]),
                .params = file.Numbers({"intrinsics"}, 4)};
  return Distorted(file, camera, file.Text("distortion_model"), distortion);
}

// Distortion that the file gives but the model lacks would silently be ignored.
void RefuseStrayParameters(const CameraSection& file, const std::vector<std::string>& used,
                           const std::string& model) {
  for (const char* name : {"k", "k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2"}) {
    const bool known = std::ranges::find(used, name) != used.end();
    if (!known && file.Has({name}) && file.Number({name}) != 0) {
      file.Refuse(std::string(name) + " is not a parameter of " + model +
                  "; use a camera_model that has it, or remove it");
    }
  }
}

// Our own: the model by COLMAP's name, and its parameters by theirs.
Camera ReadOwnCamera(const CameraSection& file) {
  const std::string name = file.Text("camera_model");
  const auto model = CameraModelByName(name);
  if (!model) {
    file.Refuse("the camera_model '" + name +
                "' is unknown; use a COLMAP model name such as PINHOLE or OPENCV");
  }
  Camera camera{
      .model = *model, .width = file.Size(kWidth), .height = file.Size(kHeight), .params = {}};
  std::vector<std::string> used = Words(ParameterNames(*model));
  for (std::string& parameter : used) {
    // A single focal length or coefficient may have the name of the first of several.
    if (parameter == "f" && !file.Has({"f"}) && file.Has({"fx"})) parameter = "fx";
    if (parameter == "k" && !file.Has({"k"}) && file.Has({"k1"})) parameter = "k1";
    camera.params.push_back(file.Number({parameter.c_str()}));
  }
  RefuseStrayParameters(file, used, name);
  return camera;
}

// OpenCV writes "%YAML:1.0", which isn't a valid YAML directive; the line is emptied but kept, so
// that line numbers stay right.
std::string WithoutDirectives(std::string text) {
  for (size_t line = 0; line < text.size();) {
    const size_t end = std::min(text.find('\n', line), text.size());
    if (text[line] == '%') std::fill(text.begin() + line, text.begin() + end, ' ');
    line = end + 1;
  }
  return text;
}

}  // namespace

Camera ReadCameraSection(const CameraSection& file) {
  if (file.Has({"intrinsics"})) return ReadKalibrCamera(file);
  // A `k` may be a matrix, or a coefficient of our own format.
  if (file.Has({"camera_model"}) && !file.Has({"camera_matrix"})) return ReadOwnCamera(file);
  if (file.Has(kMatrix)) return ReadMatrixCamera(file);
  file.Refuse(
      "its keys (" + file.Keys() +
      ") match no supported format; use a file of OpenCV, ROS, Kalibr or COLMAP, or the keys "
      "camera_model, image_width, image_height, fx, fy, cx, cy");
}

CameraSection OpenCameraYaml(const fs::path& path) {
  constexpr int64_t kMaxBytes = 1 << 20;  // a calibration has a few kilobytes
  const std::string text = WithoutDirectives(ReadText(path, kMaxBytes, ErrorCode::kBadCamera));
  const CameraSection nothing(path, {});
  if (text.starts_with('<')) nothing.Refuse("it is XML, which is not supported; save it as YAML");
  try {
    const YAML::Node root = YAML::Load(text);
    if (!root.IsMap()) nothing.Refuse("it has no keys and values; expected a YAML camera file");
    return {path, root};
  } catch (const YAML::Exception& error) {
    nothing.Refuse("line " + std::to_string(error.mark.line + 1) + " is not valid YAML (" +
                   error.msg + ")");
  }
}

Camera ReadCameraFile(const fs::path& path) {
  const auto read_yaml = [&] {
    const CameraSection file = OpenCameraYaml(path);
    return file.Has({"cam0"}) ? ReadKalibrCamera(file.Under("cam0")) : ReadCameraSection(file);
  };
  Camera camera = LooksLikeColmap(path) ? ReadColmapCamera(path) : read_yaml();
  try {
    CheckCamera(camera);
  } catch (const MapError& error) {
    throw MapError(ErrorCode::kBadCamera, Quoted(path) + ": " + error.what());
  }
  return camera;
}

}  // namespace waystone
