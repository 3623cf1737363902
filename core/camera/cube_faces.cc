// SPDX-License-Identifier: Apache-2.0
#include "core/camera/cube_faces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <string>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/camera/camera.h"
#include "core/geometry/angle.h"

namespace waystone {
namespace {

constexpr std::array<std::string_view, kCubeFaces> kNames = {"front", "right", "back",
                                                             "left",  "up",    "down"};

std::string NameText(CubeFace face) { return std::string(NameOf(face)); }

void CheckFaces(const FaceImages& faces) {
  const int width = faces[0].cols;
  for (int i = 0; i < kCubeFaces; ++i) {
    const auto face = static_cast<CubeFace>(i);
    const cv::Mat& image = faces[i];
    if (image.empty() && (face == CubeFace::kUp || face == CubeFace::kDown)) continue;
    if (image.empty()) {
      throw MapError(ErrorCode::kBadImage,
                     "the rig's face '" + NameText(face) +
                         "' is missing; front, right, back and left are required");
    }
    if (image.cols != width || image.rows != width) {
      throw MapError(ErrorCode::kBadImage, "the rig's face '" + NameText(face) + "' has " +
                                               std::to_string(image.cols) + "x" +
                                               std::to_string(image.rows) + " pixels, not " +
                                               std::to_string(width) + "x" + std::to_string(width) +
                                               "; faces must be square and of one size");
    }
  }
}

cv::Mat GreyFace(const cv::Mat& image) {
  if (image.channels() == 1) return image;
  cv::Mat grey;
  cv::cvtColor(image, grey, image.channels() == 3 ? cv::COLOR_BGR2GRAY : cv::COLOR_BGRA2GRAY);
  return grey;
}

// The face that a ray of the rig goes through.
CubeFace FaceAlong(const Eigen::Vector3d& ray) {
  Eigen::Index axis = 0;
  ray.cwiseAbs().maxCoeff(&axis);
  if (axis == 1) return ray.y() < 0 ? CubeFace::kUp : CubeFace::kDown;
  if (axis == 0) return ray.x() > 0 ? CubeFace::kRight : CubeFace::kLeft;
  return ray.z() > 0 ? CubeFace::kFront : CubeFace::kBack;
}

// The ray's pixel in the face, kept inside it so that no neighbour in the atlas bleeds in.
cv::Point2f PixelIn(CubeFace face, const Eigen::Vector3d& ray, int width) {
  const Eigen::Vector3d x = RigFromFace(face).transpose() * ray;
  const double centre = (width - 1) / 2.0;
  const double focal = width / 2.0;
  const auto at = [&](double slope) {
    return static_cast<float>(std::clamp(centre + focal * slope, 0.0, width - 1.0));
  };
  return {at(x.x() / x.z()), at(x.y() / x.z())};
}

}  // namespace

std::string_view NameOf(CubeFace face) { return kNames.at(static_cast<size_t>(face)); }

Eigen::Matrix3d RigFromFace(CubeFace face) {
  Eigen::Matrix3d rotation;  // columns: the face's right, down and forward
  switch (face) {
    case CubeFace::kFront:
      return Eigen::Matrix3d::Identity();
    case CubeFace::kRight:
      rotation << 0, 0, 1, 0, 1, 0, -1, 0, 0;
      break;
    case CubeFace::kBack:
      rotation << -1, 0, 0, 0, 1, 0, 0, 0, -1;
      break;
    case CubeFace::kLeft:
      rotation << 0, 0, -1, 0, 1, 0, 1, 0, 0;
      break;
    case CubeFace::kUp:
      rotation << 1, 0, 0, 0, 0, -1, 0, 1, 0;
      break;
    case CubeFace::kDown:
      rotation << 1, 0, 0, 0, 0, 1, 0, -1, 0;
      break;
  }
  return rotation;
}

Panorama FromFaces(const FaceImages& faces, const PanoramaOptions& options) {
  options.Check();
  CheckFaces(faces);
  const int width = faces[0].cols;
  constexpr int kMaxWidth = std::numeric_limits<int16_t>::max() / kCubeFaces - 1;  // cv::remap's
  if (width > kMaxWidth) {
    throw MapError(ErrorCode::kBadImage, "the rig's faces are " + std::to_string(width) +
                                             " px wide, more than the limit of " +
                                             std::to_string(kMaxWidth) + "; downscale them");
  }
  cv::Mat atlas(kCubeFaces * width, width, CV_8UC1, cv::Scalar(0));  // one face below the other
  for (int i = 0; i < kCubeFaces; ++i) {
    if (!faces[i].empty()) GreyFace(faces[i]).copyTo(atlas.rowRange(i * width, (i + 1) * width));
  }
  const auto has = [&](CubeFace face) { return !faces[static_cast<size_t>(face)].empty(); };
  const double corner_rad = std::atan(std::numbers::sqrt2 / 2);
  Panorama panorama;
  panorama.band = {has(CubeFace::kUp) ? kPi / 2 : corner_rad,
                   has(CubeFace::kDown) ? -kPi / 2 : -corner_rad};
  const double height_rad = panorama.band.top_rad - panorama.band.bottom_rad;
  const int rows = std::max(1, cvRound(options.columns * height_rad / (2 * kPi)));
  cv::Mat map(rows, options.columns, CV_32FC2);
  for (int y = 0; y < rows; ++y) {
    const double elevation = panorama.band.top_rad - (y + 0.5) * height_rad / rows;
    for (int x = 0; x < options.columns; ++x) {
      const double azimuth = 2 * kPi * (x + 0.5) / options.columns - kPi;
      const Eigen::Vector3d ray(std::cos(elevation) * std::sin(azimuth), -std::sin(elevation),
                                std::cos(elevation) * std::cos(azimuth));
      const CubeFace face = FaceAlong(ray);
      const cv::Point2f pixel = PixelIn(face, ray, width);
      map.at<cv::Vec2f>(y, x) = {pixel.x,
                                 pixel.y + static_cast<float>(static_cast<int>(face) * width)};
    }
  }
  cv::remap(atlas, panorama.grey, map, cv::noArray(), cv::INTER_LINEAR);
  return panorama;
}

cv::Mat FaceOf(const cv::Mat& equirectangular, CubeFace face, int width_px) {
  WS_CHECK(width_px >= 1 && !equirectangular.empty(), "a face without pixels");
  const Camera sphere = {
      CameraModel::kEquirectangular, equirectangular.cols, equirectangular.rows, {}};
  const Eigen::Matrix3d rig_from_face = RigFromFace(face);
  const double focal = width_px / 2.0;
  const double centre = (width_px - 1) / 2.0;
  cv::Mat map(width_px, width_px, CV_32FC2);
  for (int y = 0; y < width_px; ++y) {
    for (int x = 0; x < width_px; ++x) {
      const Eigen::Vector3d ray((x - centre) / focal, (y - centre) / focal, 1);
      const auto pixel = Project(sphere, rig_from_face * ray);
      WS_CHECK(pixel.has_value(), "a ray of length 0");
      map.at<cv::Vec2f>(y, x) = {static_cast<float>(pixel->x()), static_cast<float>(pixel->y())};
    }
  }
  cv::Mat image;
  cv::remap(equirectangular, image, map, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_WRAP);
  return image;
}

}  // namespace waystone
