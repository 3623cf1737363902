// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/image_changes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/image/encode.h"

namespace waystone::bench {
namespace {

// The part of the image about its middle.
cv::Mat CropMiddle(const cv::Mat& grey, double width_share, double height_share) {
  const cv::Size size(static_cast<int>(grey.cols * width_share),
                      static_cast<int>(grey.rows * height_share));
  return grey(
             {(grey.cols - size.width) / 2, (grey.rows - size.height) / 2, size.width, size.height})
      .clone();
}

cv::Mat Resize(const cv::Mat& grey, cv::Size size) {
  cv::Mat resized;
  const bool smaller = size.width < grey.cols;
  cv::resize(grey, resized, size, 0, 0, smaller ? cv::INTER_AREA : cv::INTER_CUBIC);
  return resized;
}

// A longer lens on the same sensor.
cv::Mat Magnify(const cv::Mat& grey, double factor) {
  return Resize(CropMiddle(grey, 1 / factor, 1 / factor), grey.size());
}

// The same view in another number of pixels.
cv::Mat Rescale(const cv::Mat& grey, double factor) {
  return Resize(grey, {static_cast<int>(grey.cols * factor), static_cast<int>(grey.rows * factor)});
}

cv::Mat Turn(const cv::Mat& grey) {
  cv::Mat turned;
  cv::rotate(grey, turned, cv::ROTATE_90_CLOCKWISE);
  return turned;
}

// As a lens with the picture's own field of view would show it if its image radius grew with the
// angle: the corners lie outside.
cv::Mat Fisheye(const cv::Mat& grey) {
  constexpr double kHalfAngle_rad = 0.7;  // of a picture's width, about that of a telephone
  const double cx = (grey.cols - 1) / 2.0;
  const double cy = (grey.rows - 1) / 2.0;
  const double focal_px = cx / std::tan(kHalfAngle_rad);
  const double fisheye_px = cx / kHalfAngle_rad;
  cv::Mat map_x(grey.size(), CV_32FC1);
  cv::Mat map_y(grey.size(), CV_32FC1);
  for (int y = 0; y < grey.rows; ++y) {
    for (int x = 0; x < grey.cols; ++x) {
      const double radius = std::hypot(x - cx, y - cy);
      const double scale =
          radius > 0 ? focal_px * std::tan(radius / fisheye_px) / radius : focal_px / fisheye_px;
      map_x.at<float>(y, x) = static_cast<float>(cx + scale * (x - cx));
      map_y.at<float>(y, x) = static_cast<float>(cy + scale * (y - cy));
    }
  }
  cv::Mat bent;
  cv::remap(grey, bent, map_x, map_y, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  return bent;
}

cv::Mat Compress(const cv::Mat& grey, int quality) {
  return cv::imdecode(EncodeJpeg(grey, quality), cv::IMREAD_GRAYSCALE);
}

// A hand that moves along a line, in any direction, while the shutter is open.
cv::Mat MoveWhileExposing(const cv::Mat& grey, double share_of_width, Random& random) {
  const int length = std::max(3, static_cast<int>(share_of_width * grey.cols)) | 1;
  const double angle = random.Uniform(0, std::numbers::pi);
  cv::Mat kernel = cv::Mat::zeros(length, length, CV_32FC1);
  const double half = (length - 1) / 2.0;
  for (int i = 0; i < length; ++i) {
    const double t = i - half;
    kernel.at<float>(static_cast<int>(std::lround(half + t * std::sin(angle))),
                     static_cast<int>(std::lround(half + t * std::cos(angle)))) = 1;
  }
  kernel /= cv::sum(kernel)[0];
  cv::Mat blurred;
  cv::filter2D(grey, blurred, -1, kernel, {-1, -1}, 0, cv::BORDER_REPLICATE);
  return blurred;
}

// A change that draws nothing.
template <typename Apply>
ImageChange Fixed(const std::string& name, Apply apply) {
  return {name, [apply](const cv::Mat& grey, Random&) { return apply(grey); }};
}

}  // namespace

cv::Mat Expose(const cv::Mat& grey, double gain, double noise_sigma, Random& random) {
  cv::Mat exposed(grey.size(), CV_8UC1);
  std::transform(grey.begin<uint8_t>(), grey.end<uint8_t>(), exposed.begin<uint8_t>(),
                 [&](uint8_t value) {
                   return cv::saturate_cast<uint8_t>(gain * value + noise_sigma * random.Normal());
                 });
  return exposed;
}

std::vector<ImageChange> ImageChanges() {
  using cv::Mat;
  return {Fixed("as it is", [](const Mat& grey) { return grey; }),
          Fixed("1.25 times the focal length", [](const Mat& grey) { return Magnify(grey, 1.25); }),
          Fixed("1.6 times the focal length", [](const Mat& grey) { return Magnify(grey, 1.6); }),
          Fixed("half the resolution", [](const Mat& grey) { return Rescale(grey, 0.5); }),
          Fixed("twice the resolution", [](const Mat& grey) { return Rescale(grey, 2); }),
          Fixed("portrait crop", [](const Mat& grey) { return CropMiddle(grey, 0.5625, 1); }),
          Fixed("turned by 90 degrees", [](const Mat& grey) { return Turn(grey); }),
          Fixed("fisheye", [](const Mat& grey) { return Fisheye(grey); }),
          {"dark, a fifth of the light",
           [](const Mat& grey, Random& random) { return Expose(grey, 0.2, 2, random); }},
          {"overexposed, twice the light",
           [](const Mat& grey, Random& random) { return Expose(grey, 2, 2, random); }},
          Fixed("JPEG quality 30", [](const Mat& grey) { return Compress(grey, 30); }),
          {"motion blur, 1 % of the width",
           [](const Mat& grey, Random& random) { return MoveWhileExposing(grey, 0.01, random); }}};
}

}  // namespace waystone::bench
