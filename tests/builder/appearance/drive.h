// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <tbb/parallel_for.h>

#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <set>
#include <string>
#include <vector>

#include "builder/sources/source.h"
#include "core/geometry/pose2.h"
#include "core/panorama/fourier_signature.h"
#include "core/trajectory/shape_difference.h"
#include "world/render.h"
#include "world/rig.h"
#include "world/setting.h"
#include "world/world.h"

namespace waystone {

// The elevations that signatures use.
inline const ElevationBand kBand = SignatureOptions{}.band;

// A circle through a room of the demo building, once around and a bit more, with panoramas and
// their truth: rendered once for all tests.
struct Drive {
  static constexpr int kFrames = 48;
  static constexpr int kAround = 40;  // frames of one round
  std::vector<cv::Mat> panoramas;
  std::vector<Pose2> truth;

  Drive() : panoramas(kFrames) {
    const World world(DemoPlan(), WorldOptions{.texture_richness = 0.5});
    const Renderer renderer(PanoramaCamera(256));
    std::vector<Eigen::Isometry3d> poses;
    for (int i = 0; i < kFrames; ++i) {
      const double angle = 2 * std::numbers::pi * i / kAround;
      // The camera doesn't look along its trajectory all the time.
      const double yaw = angle + std::numbers::pi / 2 + 0.3 * std::sin(2 * angle);
      truth.push_back(
          {6.5 + 0.9 * std::cos(angle), 10.5 + 0.6 * std::sin(angle), WrappedAngle(yaw)});
      poses.push_back(WorldFromCamera({truth.back().x, truth.back().y, 1.2}, yaw));
    }
    tbb::parallel_for(0, kFrames, [&](int i) {
      RenderOptions options;
      options.noise_sigma = 3;
      options.noise_seed = static_cast<uint64_t>(i) + 1;
      panoramas[i] = renderer.Render(world, poses[i], options).grey;
    });
  }
};

inline const Drive& TheDrive() {
  static const Drive drive;
  return drive;
}

// The drive in signatures.
inline std::vector<FourierSignature> DriveSignatures() {
  std::vector<FourierSignature> signatures;
  for (const cv::Mat& panorama : TheDrive().panoramas) signatures.push_back(Signature(panorama));
  return signatures;
}

inline Points2 PlacesOf(const std::vector<Pose2>& poses) {
  Points2 places;
  for (const Pose2& pose : poses) places.emplace_back(pose.x, pose.y);
  return places;
}

// Images from memory.
class ImagesSource : public Source {
 public:
  explicit ImagesSource(std::vector<cv::Mat> images, std::string name = "drive")
      : images_(std::move(images)), name_(std::move(name)) {}

  const std::string& kind() const override { return kind_; }
  const std::string& name() const override { return name_; }
  int size() const override { return static_cast<int>(images_.size()); }
  const std::optional<Camera>& camera() const override { return camera_; }
  cv::Size frame_size() const override { return images_.empty() ? cv::Size() : images_[0].size(); }
  std::string Announcement() const override { return "Images in memory"; }

  std::optional<EncodedFrame> NextEncoded() override {
    if (next_ >= size()) return std::nullopt;
    const int i = next_++;
    return EncodedFrame({i, "image " + std::to_string(i), {}},
                        [image = images_[i]] { return image; });
  }

 private:
  std::vector<cv::Mat> images_;
  std::string kind_ = "folder";
  std::string name_;
  std::optional<Camera> camera_;
  int next_ = 0;
};

}  // namespace waystone
