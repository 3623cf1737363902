// SPDX-License-Identifier: Apache-2.0
#include "localizer/appearance/panorama_features.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/option_range.h"
#include "core/camera/cube_faces.h"
#include "core/camera/rig.h"
#include "core/features/descriptor_codes.h"

namespace waystone {
namespace {

constexpr CubeFace kSides[] = {CubeFace::kFront, CubeFace::kRight, CubeFace::kBack,
                               CubeFace::kLeft};

int16_t UnitsOf(double angle_rad) {
  // Pi and minus pi are one azimuth: 32768 doesn't fit.
  return static_cast<int16_t>(
      std::clamp(std::lround(angle_rad / kBearingUnit_rad), -32768L, 32767L));
}

Bearing BearingOf(const Eigen::Vector3d& ray) {
  return {UnitsOf(std::atan2(ray.x(), ray.z())), UnitsOf(std::asin(-ray.normalized().y()))};
}

Eigen::Vector3d RayOf(const Bearing& bearing) {
  const double azimuth = bearing.azimuth * kBearingUnit_rad;
  const double elevation = bearing.elevation * kBearingUnit_rad;
  const double level = std::cos(elevation);
  return {level * std::sin(azimuth), -std::sin(elevation), level * std::cos(azimuth)};
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
                                             " is not twice as wide as high; send a full panorama");
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
  kept.codes = EncodeDescriptors(features.descriptors, features.type);
  return kept;
}

BearingFeatures ToBearingFeatures(const NodeFeatures& features, FeatureType type) {
  BearingFeatures rays;
  rays.type = type;
  for (const Bearing& bearing : features.bearings) rays.rays.push_back(RayOf(bearing));
  rays.descriptors = DecodeDescriptors(features.codes, type);
  return rays;
}

}  // namespace waystone
