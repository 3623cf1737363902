// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bench/baseline/scenes.h"

namespace waystone::bench {

// The truth of a TUM RGB-D sequence: where a pixel of one frame is seen in another, from depth and
// poses. Not thread-safe: keeps the last depth image.
class RgbdTruth {
 public:
  static constexpr int kWidth_px = 640;  // of its images

  // Reads rgb.txt, depth.txt, groundtruth.txt (depth camera to world) of `folder`. Intrinsics are
  // those of the kitchen data: colour f 515, depth f 585, centres (320, 240), millimetres.
  explicit RgbdTruth(const std::filesystem::path& folder);

  int frames() const { return static_cast<int>(images_.size()); }
  const std::string& image(int frame) const { return images_[frame]; }
  bool HasDepth(int frame) const { return depths_.contains(frame); }
  const Eigen::Isometry3d& world_from_camera(int frame) const { return world_from_camera_[frame]; }
  // Of the colour camera, beside the depth camera.
  Eigen::Isometry3d world_from_colour(int frame) const;
  // The pixel of frame b that shows what pixel x of frame a shows; nothing without depth there.
  std::optional<Eigen::Vector2d> Transfer(int a, const Eigen::Vector2d& x, int b) const;
  // The median distance, px of the reference frame, of an answer's points from where the truth has
  // those of the query, which is a frame, too; nothing with fewer than five that have a depth.
  std::optional<double> MedianError(int query, const SceneAnswer& answer) const;

 private:
  std::filesystem::path folder_;
  std::vector<std::string> images_;
  std::map<int, std::string> depths_;
  std::vector<Eigen::Isometry3d> world_from_camera_;
  mutable int loaded_ = -1;
  mutable cv::Mat depth_;
};

}  // namespace waystone::bench
