// SPDX-License-Identifier: Apache-2.0
#include "world/render.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/check.h"
#include "world/texture.h"

namespace waystone {
namespace {

// cv::GaussianBlur would start threads of its own; sepFilter2D stays on this one.
cv::Mat Blurred(const cv::Mat& light, double sigma_px, bool wraps) {
  const int radius = std::max(1, static_cast<int>(std::ceil(3.0 * sigma_px)));
  const cv::Mat kernel = cv::getGaussianKernel(2 * radius + 1, sigma_px, CV_32F);
  cv::Mat wide = light;
  // In a panorama the last column is next to the first.
  if (wraps) cv::copyMakeBorder(light, wide, 0, 0, radius, radius, cv::BORDER_WRAP);
  cv::Mat blurred;
  cv::sepFilter2D(wide, blurred, CV_32F, kernel, kernel, {-1, -1}, 0.0, cv::BORDER_REPLICATE);
  return wraps ? blurred.colRange(radius, radius + light.cols).clone() : blurred;
}

// Nearly normal noise of standard deviation 1 from one number: the sum of its four 16 bit parts.
// Depends only on seed and pixel, and is far cheaper than a normal distribution.
float UnitNoise(uint64_t seed, uint64_t pixel) {
  const uint64_t bits = MixSeeds(seed, pixel);
  const auto sum = static_cast<float>((bits & 0xFFFF) + ((bits >> 16) & 0xFFFF) +
                                      ((bits >> 32) & 0xFFFF) + (bits >> 48));
  constexpr float kMean = 2.0F * 65535.0F;
  constexpr float kSigma = 65536.0F * 0.57735027F;  // sqrt(4 / 12)
  return (sum - kMean) / kSigma;
}

// Light to grey values: gain, noise, cut and rounded.
cv::Mat Expose(const cv::Mat& light, const RenderOptions& options) {
  cv::Mat grey(light.size(), CV_8UC1);
  const auto gain = static_cast<float>(options.exposure_gain);
  const auto sigma = static_cast<float>(options.noise_sigma);
  uint64_t pixel = 0;
  for (int y = 0; y < light.rows; ++y) {
    const auto* in = light.ptr<float>(y);
    auto* out = grey.ptr<uint8_t>(y);
    for (int x = 0; x < light.cols; ++x, ++pixel) {
      float value = gain * in[x];
      if (sigma > 0.0F) value += sigma * UnitNoise(options.noise_seed, pixel);
      // Never negative, so adding a half rounds. NOLINTNEXTLINE(bugprone-incorrect-roundings)
      out[x] = static_cast<uint8_t>(std::clamp(value, 0.0F, 255.0F) + 0.5F);
    }
  }
  return grey;
}

}  // namespace

Eigen::Isometry3d PartOfMotion(const Eigen::Isometry3d& motion, double share) {
  const Eigen::AngleAxisd turn(motion.rotation());
  Eigen::Isometry3d part = Eigen::Isometry3d::Identity();
  part.linear() = Eigen::AngleAxisd(share * turn.angle(), turn.axis()).toRotationMatrix();
  part.translation() = share * motion.translation();
  return part;
}

void RenderOptions::Check() const { CheckFields("render", *this); }

// One sharp picture from one pose.
class Renderer::Pass {
 public:
  Pass(const Renderer& renderer, const World& world, const Eigen::Isometry3d& world_from_camera)
      : renderer_(renderer),
        world_(world),
        rotation_(world_from_camera.linear()),
        centre_(world_from_camera.translation()),
        size_(renderer.camera_.width, renderer.camera_.height),
        light_(size_, CV_32FC1),
        face_ids_(size_, CV_16UC1) {}

  void CastAll(cv::Mat* depth) {
    const bool along_axis = renderer_.camera_.model != CameraModel::kEquirectangular;
    for (int y = 0; y < size_.height; ++y) {
      for (int x = 0; x < size_.width; ++x) {
        const size_t i = Index(x, y);
        const RayHit hit = CastRay(renderer_.rays_[i].cast<double>(), renderer_.cones_rad_[i],
                                   light_.at<float>(y, x));
        face_ids_.at<uint16_t>(y, x) = static_cast<uint16_t>(hit.face);
        if (depth == nullptr) continue;
        const double scale = along_axis ? renderer_.rays_[i].z() : 1.0;
        depth->at<float>(y, x) = static_cast<float>(hit.t * scale);
      }
    }
  }

  // Casts more rays into the pixels where two faces meet.
  void SmoothEdges(int rays) {
    if (rays <= 1) return;
    for (int y = 0; y < size_.height; ++y) {
      for (int x = 0; x < size_.width; ++x) {
        if (IsEdge(x, y)) light_.at<float>(y, x) = MeanOfRays(x, y, rays);
      }
    }
  }

  const cv::Mat& light() const { return light_; }
  const cv::Mat& face_ids() const { return face_ids_; }

 private:
  size_t Index(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(size_.width) + static_cast<size_t>(x);
  }

  RayHit CastRay(const Eigen::Vector3d& ray, double cone_rad, float& light) const {
    const Eigen::Vector3d direction = rotation_ * ray;
    const RayHit hit = world_.Cast(centre_, direction);
    light = world_.Shade(centre_, direction, hit, cone_rad);
    return hit;
  }

  bool IsEdge(int x, int y) const {
    const auto at = [&](int column, int row) {
      return face_ids_.at<uint16_t>(std::clamp(row, 0, size_.height - 1),
                                    std::clamp(column, 0, size_.width - 1));
    };
    const uint16_t face = at(x, y);
    return at(x - 1, y) != face || at(x + 1, y) != face || at(x, y - 1) != face ||
           at(x, y + 1) != face;
  }

  // Change of the ray from a pixel to the next one, along a row (dx 1) or column (dy 1).
  Eigen::Vector3d RayStep(int x, int y, int dx, int dy) const {
    const int x0 = std::max(x - dx, 0);
    const int y0 = std::max(y - dy, 0);
    const int x1 = std::min(x + dx, size_.width - 1);
    const int y1 = std::min(y + dy, size_.height - 1);
    const int steps = std::max(x1 - x0 + y1 - y0, 1);
    const Eigen::Vector3f change = renderer_.rays_[Index(x1, y1)] - renderer_.rays_[Index(x0, y0)];
    return change.cast<double>() / steps;
  }

  float MeanOfRays(int x, int y, int rays) const {
    const size_t i = Index(x, y);
    const Eigen::Vector3d centre = renderer_.rays_[i].cast<double>();
    const Eigen::Vector3d right = RayStep(x, y, 1, 0);
    const Eigen::Vector3d down = RayStep(x, y, 0, 1);
    float sum = 0.0F;
    for (int k = 0; k < rays * rays; ++k) {
      const int row = k / rays;
      const double dx = (k % rays + 0.5) / rays - 0.5;
      const double dy = (row + 0.5) / rays - 0.5;
      const Eigen::Vector3d ray = (centre + dx * right + dy * down).normalized();
      float light = 0.0F;
      CastRay(ray, renderer_.cones_rad_[i] / rays, light);
      sum += light;
    }
    return sum / static_cast<float>(rays * rays);
  }

  const Renderer& renderer_;
  const World& world_;
  const Eigen::Matrix3d rotation_;
  const Eigen::Vector3d centre_;
  const cv::Size size_;
  cv::Mat light_;
  cv::Mat face_ids_;
};

Renderer::Renderer(const Camera& camera) : camera_(camera) {
  CheckCamera(camera_);
  const auto width = static_cast<size_t>(camera_.width);
  const auto pixels = width * static_cast<size_t>(camera_.height);
  rays_.reserve(pixels);
  for (int y = 0; y < camera_.height; ++y) {
    for (int x = 0; x < camera_.width; ++x) {
      rays_.emplace_back(Unproject(camera_, {x, y}).normalized().cast<float>());
    }
  }
  cones_rad_.resize(pixels);
  for (size_t i = 0; i < pixels; ++i) {
    const size_t beside = (i + 1) % width != 0 ? i + 1 : (i > 0 ? i - 1 : i);
    const size_t below = i + width < pixels ? i + width : (i >= width ? i - width : i);
    // The longer of the two: slightly blurs a panorama's poles instead of letting them alias.
    cones_rad_[i] = std::max((rays_[beside] - rays_[i]).norm(), (rays_[below] - rays_[i]).norm());
  }
}

cv::Mat Renderer::MeanLight(const World& world, const Eigen::Isometry3d& world_from_camera,
                            const RenderOptions& options) const {
  cv::Mat sum = cv::Mat::zeros(camera_.height, camera_.width, CV_32FC1);
  int passes = 0;
  for (int i = 0; i < options.motion_samples; ++i) {
    const double share = (i + 0.5) / options.motion_samples - 0.5;
    const Eigen::Isometry3d pose = world_from_camera * PartOfMotion(options.motion, share);
    if (!world.IsInside(pose.translation())) continue;
    Pass pass(*this, world, pose);
    pass.CastAll(nullptr);
    pass.SmoothEdges(options.edge_rays);
    sum += pass.light();
    ++passes;
  }
  WS_CHECK(passes > 0, "the camera is inside a wall while the shutter is open");
  return sum / passes;
}

RenderedFrame Renderer::Render(const World& world, const Eigen::Isometry3d& world_from_camera,
                               const RenderOptions& options) const {
  options.Check();
  WS_CHECK(world.IsInside(world_from_camera.translation()), "the camera is inside a wall");
  RenderedFrame frame;
  if (options.depth) frame.depth.create(camera_.height, camera_.width, CV_32FC1);

  Pass pass(*this, world, world_from_camera);
  pass.CastAll(options.depth ? &frame.depth : nullptr);
  pass.SmoothEdges(options.edge_rays);
  frame.face_ids = pass.face_ids();
  frame.plane_ids.create(frame.face_ids.size(), CV_16UC1);
  std::transform(frame.face_ids.begin<uint16_t>(), frame.face_ids.end<uint16_t>(),
                 frame.plane_ids.begin<uint16_t>(),
                 [&](uint16_t face) { return static_cast<uint16_t>(world.FaceById(face).plane); });

  cv::Mat light =
      options.motion_samples > 1 ? MeanLight(world, world_from_camera, options) : pass.light();
  if (options.lens_blur_px > 0.0) {
    light = Blurred(light, options.lens_blur_px, camera_.model == CameraModel::kEquirectangular);
  }
  frame.grey = Expose(light, options);
  return frame;
}

RenderedFrame Render(const World& world, const Camera& camera,
                     const Eigen::Isometry3d& world_from_camera, const RenderOptions& options) {
  return Renderer(camera).Render(world, world_from_camera, options);
}

}  // namespace waystone
