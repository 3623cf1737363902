// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace waystone {

// Camera models by COLMAP's names; their parameters in COLMAP's order.
// The values are written into map files: never change them.
enum class CameraModel {
  kSimplePinhole = 0,     // SIMPLE_PINHOLE   f cx cy
  kPinhole = 1,           // PINHOLE          fx fy cx cy
  kSimpleRadial = 2,      // SIMPLE_RADIAL    f cx cy k
  kRadial = 3,            // RADIAL           f cx cy k1 k2
  kOpenCv = 4,            // OPENCV           fx fy cx cy k1 k2 p1 p2
  kOpenCvFisheye = 5,     // OPENCV_FISHEYE   fx fy cx cy k1 k2 k3 k4
  kFullOpenCv = 6,        // FULL_OPENCV      fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6
  kEquirectangular = 100  // EQUIRECTANGULAR  (none): columns are azimuth, rows are elevation
};

// A camera: how a ray in its frame becomes a pixel. Frame: x right, y down, z forward (optical
// axis), as in OpenCV. Pixel (0, 0) is the centre of the top left pixel, as in OpenCV, ROS and
// Kalibr; COLMAP calls that point (0.5, 0.5), so half a pixel is taken off cx and cy where its
// files are read. Distortions are OpenCV's: x' = X / Z, y' = Y / Z, s = x'^2 + y'^2 for the radial
// and tangential ones, a polynomial in the angle to the optical axis for the fisheye.
// Equirectangular: the whole sphere; the middle of the image, ((width - 1) / 2, (height - 1) / 2),
// looks along +z, columns grow towards +x, rows grow towards +y. Azimuth atan2(X, Z) runs over the
// width, elevation asin(Y / |x|) over the height. The seam is straight behind.
struct Camera {
  CameraModel model = CameraModel::kPinhole;
  int width = 0;   // px
  int height = 0;  // px
  std::vector<double> params;

  bool operator==(const Camera&) const = default;
};

// COLMAP's name of a model, and the reverse (nothing for an unknown name).
std::string_view NameOf(CameraModel model);
std::optional<CameraModel> CameraModelByName(std::string_view name);
// How many parameters a model has, and their names with a space between them: "fx fy cx cy".
int ParameterCount(CameraModel model);
std::string_view ParameterNames(CameraModel model);

// By how much COLMAP's pixel coordinates exceed ours, in x and y.
inline constexpr double kColmapOffset_px = 0.5;
// Adds `px` to cx and cy.
void MovePrincipalPoint(Camera& camera, double px);

// Throws MapError(kBadCamera) unless size, parameter count and parameters are sensible (1 to
// 100,000 px a side, parameters at most 1e9 in magnitude, focal lengths at least 1e-6). The
// functions below take cameras that pass it. All are thread-safe.
void CheckCamera(const Camera& camera);

// The pixel of a point or ray in the camera's frame (any length), or nothing when it lies behind
// the camera or outside the model's domain: where a distortion would fold the view back over
// itself, which is far outside the image for a sound calibration. A fisheye sees behind itself as
// far as its polynomial grows; an equirectangular camera sees everything but its own centre. The
// pixel may lie outside the image.
std::optional<Eigen::Vector2d> Project(const Camera& camera, const Eigen::Vector3d& x_camera);

// The unit ray, in the camera's frame, through a pixel: Project's inverse (to 1e-6 px inside the
// image for distortions of ordinary lenses). For a pixel that no ray reaches, the ray that comes
// nearest to it; always finite for a finite pixel.
Eigen::Vector3d Unproject(const Camera& camera, const Eigen::Vector2d& pixel);

}  // namespace waystone
