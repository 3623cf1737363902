// SPDX-License-Identifier: Apache-2.0
#include "localizer/appearance/panorama_features.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/camera/cube_faces.h"
#include "core/camera/rig.h"

namespace waystone {
namespace {

constexpr CubeFace kSides[] = {CubeFace::kFront, CubeFace::kRight, CubeFace::kBack,
                               CubeFace::kLeft};

}  // namespace

void PanoramaFeatureOptions::Check() const {
  bearings.Check();
  CheckFields("panorama_features", *this);
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

BearingFeatures ExtractScaledPanorama(const cv::Mat& grey, const PanoramaFeatureOptions& options) {
  if (grey.cols == 2 * grey.rows) return ExtractPanoramaFeatures(grey, options);
  const int rows = std::max(1, grey.cols / 2);
  cv::Mat whole;
  cv::resize(grey, whole, {2 * rows, rows}, 0, 0, cv::INTER_AREA);
  return ExtractPanoramaFeatures(whole, options);
}

}  // namespace waystone
