// SPDX-License-Identifier: Apache-2.0
#include "localizer/panorama_features.h"

#include <cmath>
#include <string>
#include <vector>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/option_range.h"
#include "core/camera/cube_faces.h"
#include "core/camera/rig.h"

namespace waystone {
namespace {

constexpr CubeFace kSides[] = {CubeFace::kFront, CubeFace::kRight, CubeFace::kBack,
                               CubeFace::kLeft};

Bearing BearingOf(const Eigen::Vector3d& ray) {
  return {static_cast<float>(std::atan2(ray.x(), ray.z())),
          static_cast<float>(std::asin(-ray.normalized().y()))};
}

Eigen::Vector3d RayOf(const Bearing& bearing) {
  const double level = std::cos(bearing.elevation_rad);
  return {level * std::sin(bearing.azimuth_rad), -std::sin(bearing.elevation_rad),
          level * std::cos(bearing.azimuth_rad)};
}

}  // namespace

void PanoramaFeatureOptions::Check() const {
  bearings.Check();
  CheckRange("face_width", face_width, 0.05, 1);
}

BearingFeatures ExtractPanoramaFeatures(const cv::Mat& equirectangular,
                                        const PanoramaFeatureOptions& options) {
  options.Check();
  if (equirectangular.type() != CV_8UC1 || equirectangular.cols != 2 * equirectangular.rows) {
    throw MapError(ErrorCode::kBadImage, "a panorama of " + std::to_string(equirectangular.cols) +
                                             "x" + std::to_string(equirectangular.rows) +
                                             " isn't twice as wide as high; send a whole one");
  }
  const int width_px = std::max(1, static_cast<int>(options.face_width * equirectangular.cols));
  std::vector<cv::Mat> faces(kCubeFaces);
  for (const CubeFace side : kSides) {
    faces[static_cast<size_t>(side)] = FaceOf(equirectangular, side, width_px);
  }
  return ExtractBearings(CubeRig(width_px), faces, options.bearings);
}

NodeFeatures ToNodeFeatures(const BearingFeatures& features) {
  NodeFeatures kept;
  for (const Eigen::Vector3d& ray : features.rays) kept.bearings.push_back(BearingOf(ray));
  kept.descriptors = features.descriptors;
  return kept;
}

BearingFeatures ToBearingFeatures(const NodeFeatures& features, FeatureType type) {
  BearingFeatures rays;
  rays.type = type;
  for (const Bearing& bearing : features.bearings) rays.rays.push_back(RayOf(bearing));
  rays.descriptors = features.descriptors;
  return rays;
}

}  // namespace waystone
