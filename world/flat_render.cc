// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/base/check.h"
#include "core/robust/median.h"
#include "world/flat.h"
#include "world/texture.h"

namespace waystone {
namespace {

constexpr double kGamma = 2.2;
constexpr double kGlareSigma = 0.012;  // of the width
constexpr int kEdgeRays = 2;           // along each side of a pixel where two faces meet
constexpr double kMaxGain = 40;        // the darkest that the camera makes bright

class FlatPass {
 public:
  FlatPass(const Flat& flat, const SceneLighting& lighting,
           const Eigen::Isometry3d& world_from_camera, int width_px)
      : view_(flat.scene, lighting, world_from_camera.translation()),
        rotation_(world_from_camera.linear()),
        size_(width_px, width_px / 2),
        step_rad_(2 * std::numbers::pi / width_px),
        light_(size_, CV_32FC1),
        faces_(size_, CV_32SC1) {}

  cv::Mat Light() {
    for (int y = 0; y < size_.height; ++y) {
      for (int x = 0; x < size_.width; ++x) {
        SceneHit hit;
        light_.at<float>(y, x) = CastAt(x, y, step_rad_, hit);
        faces_.at<int>(y, x) = 3 * hit.box + hit.axis;
      }
    }
    cv::Mat smooth = light_.clone();
    for (int y = 0; y < size_.height; ++y) {
      for (int x = 0; x < size_.width; ++x) {
        if (IsEdge(x, y)) smooth.at<float>(y, x) = MeanAround(x, y);
      }
    }
    return smooth;
  }

 private:
  // Camera frame: z to the front, x to the right, y down; the middle of the picture is the front.
  float CastAt(double x, double y, double cone_rad, SceneHit& hit) const {
    const double azimuth = (x + 0.5) * step_rad_ - std::numbers::pi;
    const double down = (y + 0.5) * step_rad_ - std::numbers::pi / 2;
    const Eigen::Vector3d ray(std::sin(azimuth) * std::cos(down), std::sin(down),
                              std::cos(azimuth) * std::cos(down));
    const Eigen::Vector3d in_world = rotation_ * ray;
    hit = view_.Cast(in_world);
    return static_cast<float>(view_.Shade(in_world, hit, cone_rad));
  }

  bool IsEdge(int x, int y) const {
    const int face = faces_.at<int>(y, x);
    const int right = faces_.at<int>(y, (x + 1) % size_.width);
    const int left = faces_.at<int>(y, (x + size_.width - 1) % size_.width);
    return face != right || face != left || face != faces_.at<int>(std::max(0, y - 1), x) ||
           face != faces_.at<int>(std::min(size_.height - 1, y + 1), x);
  }

  float MeanAround(int x, int y) const {
    float sum = 0;
    SceneHit hit;
    for (int k = 0; k < kEdgeRays * kEdgeRays; ++k) {
      const int row = k / kEdgeRays;
      const double dx = (k % kEdgeRays + 0.5) / kEdgeRays - 0.5;
      const double dy = (row + 0.5) / kEdgeRays - 0.5;
      sum += CastAt(x + dx, y + dy, step_rad_ / kEdgeRays, hit);
    }
    return sum / (kEdgeRays * kEdgeRays);
  }

  const SceneView view_;
  const Eigen::Matrix3d rotation_;
  const cv::Size size_;
  const double step_rad_;
  cv::Mat light_;
  cv::Mat faces_;
};

// The gain at which the median of the picture's light, except the floor and ceiling right below and
// above, becomes the middle grey.
float EstimateGain(const cv::Mat& light, const FlatCamera& camera) {
  std::vector<float> values;
  for (int y = light.rows / 4; y < light.rows * 3 / 4; ++y) {
    values.insert(values.end(), light.ptr<float>(y), light.ptr<float>(y) + light.cols);
  }
  const double wanted = std::pow(camera.middle_grey / 255, kGamma);
  const float median = Median(std::move(values));
  return static_cast<float>(std::min(kMaxGain, wanted / std::max<double>(median, 1e-6)));
}

// Part of the light beyond white spreads over nearby pixels.
void AddGlare(cv::Mat& light, double glare) {
  const int radius = std::max(1, static_cast<int>(3 * kGlareSigma * light.cols));
  const cv::Mat kernel = cv::getGaussianKernel(2 * radius + 1, kGlareSigma * light.cols, CV_32F);
  cv::Mat beyond = cv::max(light - 1, 0);
  cv::Mat wide;
  cv::copyMakeBorder(beyond, wide, 0, 0, radius, radius, cv::BORDER_WRAP);
  cv::sepFilter2D(wide, wide, CV_32F, kernel, kernel, {-1, -1}, 0.0, cv::BORDER_REPLICATE);
  light += glare * wide.colRange(radius, radius + light.cols);
}

float NoiseAt(uint64_t seed, uint64_t pixel) {
  const uint64_t bits = MixSeeds(seed, pixel);
  const auto sum = static_cast<float>((bits & 0xFFFF) + ((bits >> 16) & 0xFFFF) +
                                      ((bits >> 32) & 0xFFFF) + (bits >> 48));
  return (sum - 131070.0F) / 37837.23F;  // four uniform numbers: nearly normal, of sigma 1
}

}  // namespace

void FlatCamera::Check() const { CheckFields("flat_camera", *this); }

cv::Mat RenderFlat(const Flat& flat, const SceneLighting& lighting,
                   const Eigen::Isometry3d& world_from_camera, const FlatCamera& camera) {
  camera.Check();
  cv::Mat light = FlatPass(flat, lighting, world_from_camera, camera.width_px).Light();
  light *= EstimateGain(light, camera);
  AddGlare(light, camera.glare);
  cv::Mat grey(light.size(), CV_8UC1);
  uint64_t pixel = 0;
  for (int y = 0; y < light.rows; ++y) {
    for (int x = 0; x < light.cols; ++x, ++pixel) {
      const double value =
          std::pow(std::min(1.0F, std::max(0.0F, light.at<float>(y, x))), 1 / kGamma);
      const double noisy = 255 * value + camera.noise_sigma * NoiseAt(camera.noise_seed, pixel);
      grey.at<uint8_t>(y, x) = cv::saturate_cast<uint8_t>(noisy);
    }
  }
  return grey;
}

}  // namespace waystone
