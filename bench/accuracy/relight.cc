// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/relight.h"

#include <Eigen/Core>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

namespace waystone::bench {
namespace {

using Eigen::Vector2d;

// On one side of a straight edge.
struct Shadow {
  Vector2d normal;  // towards the dark side
  double offset_px = 0;
  double light = 1;  // share that falls on the dark side

  double LightAt(const Vector2d& x) const {
    return light + (1 - light) / (1 + std::exp(normal.dot(x) - offset_px));
  }
};

Shadow DrawShadow(const cv::Size& size, Random& random) {
  Shadow shadow;
  const double angle = random.Uniform(0, 2 * std::numbers::pi);
  const double x = random.Uniform(0, size.width);
  const double y = random.Uniform(0, size.height);
  shadow.normal = Vector2d(std::cos(angle), std::sin(angle));
  shadow.offset_px = shadow.normal.dot(Vector2d(x, y));
  shadow.light = random.Uniform(0.2, 0.8);
  return shadow;
}

}  // namespace

cv::Mat Relight(const RenderedFrame& frame, Random& random) {
  const double exposure = random.Uniform(0.15, 1.0);
  const double noise_sigma = random.Uniform(1, 4);
  std::vector<Shadow> shadows(random.Below(5));
  for (Shadow& shadow : shadows) shadow = DrawShadow(frame.grey.size(), random);
  std::map<int, double> of_face;
  cv::Mat relit(frame.grey.size(), CV_8UC1);
  for (int y = 0; y < relit.rows; ++y) {
    for (int x = 0; x < relit.cols; ++x) {
      const auto [face, is_new] = of_face.try_emplace(frame.face_ids.at<uint16_t>(y, x), 0.0);
      if (is_new) face->second = exposure * std::exp(random.Uniform(-1.2, 0.4));
      double light = face->second;
      for (const Shadow& shadow : shadows) light *= shadow.LightAt(Vector2d(x, y));
      relit.at<uint8_t>(y, x) = cv::saturate_cast<uint8_t>(light * frame.grey.at<uint8_t>(y, x) +
                                                           noise_sigma * random.Normal());
    }
  }
  return relit;
}

}  // namespace waystone::bench
