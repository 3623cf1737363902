// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/camera/camera.h"

namespace waystone {

// The camera of the sequence of a made map, whose keyframes have 640 x 480 px.
inline Camera MadeCamera() { return {CameraModel::kPinhole, 640, 480, {500, 500, 319.5, 239.5}}; }

// A JPEG of half the camera's size that looks along a corridor: four lines that run towards the
// middle, four upright ones and four across the view.
inline std::vector<uint8_t> MadePicture() {
  cv::Mat picture(240, 320, CV_8UC1, cv::Scalar(50));
  const auto line = [&](int x1, int y1, int x2, int y2) {
    cv::line(picture, {x1, y1}, {x2, y2}, cv::Scalar(210), 3, cv::LINE_AA);
  };
  for (const int x : {-1, 1}) {
    for (const int y : {-1, 1}) {
      line(160 + 150 * x, 120 + 100 * y, 160 + 75 * x, 120 + 50 * y);
      line(160 + 60 * x, 120 + 12 * y, 160 + 60 * x, 120 + 38 * y);
      line(160 + 8 * x, 120 + 48 * y, 160 + 40 * x, 120 + 48 * y);
    }
  }
  std::vector<uint8_t> jpeg;
  cv::imencode(".jpg", picture, jpeg, {cv::IMWRITE_JPEG_QUALITY, 95});
  return jpeg;
}

}  // namespace waystone
