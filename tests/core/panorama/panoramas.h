// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/core.hpp>
#include <vector>

#include "core/image/decode.h"
#include "world/render.h"
#include "world/rig.h"
#include "world/walk.h"
#include "world/world.h"

namespace waystone {

inline constexpr int kPanoramaWidth = 512;

// A panorama in the second room of the demo building; its front looks along `yaw_rad`.
inline cv::Mat RenderedPanorama(const Eigen::Vector2d& at_m, double yaw_rad, double pitch_rad = 0) {
  static const World world = [] {
    WorldOptions options;
    options.texel_m = 0.01;
    return World(DemoPlan(), options);
  }();
  static const Renderer renderer(PanoramaCamera(kPanoramaWidth));
  return renderer.Render(world, WorldFromCamera({at_m.x(), at_m.y(), 1.5}, yaw_rad, pitch_rad))
      .grey;
}

// In the middle of that room.
inline const Eigen::Vector2d& RoomCentre() {
  static const Eigen::Vector2d centre(6.5, 10.5);
  return centre;
}

// Real panoramas, where WAYSTONE_DATA or ../shared/data has them; none elsewhere.
inline std::vector<cv::Mat> RealPanoramas(int count) {
  const char* given = std::getenv("WAYSTONE_DATA");
  const std::filesystem::path folder =
      (given != nullptr ? std::filesystem::path(given)
                        : std::filesystem::path(WAYSTONE_SOURCE_DIR) / "../shared/data") /
      "dealership/panorama";
  std::vector<cv::Mat> panoramas;
  for (int i = 0; i < count; ++i) {
    const std::string name = std::to_string(1000 + 7 * i).substr(1) + ".jpg";
    std::ifstream file(folder / name, std::ios::binary);
    if (!file) break;
    const std::vector<uint8_t> bytes{std::istreambuf_iterator<char>(file),
                                     std::istreambuf_iterator<char>()};
    panoramas.push_back(DecodeGrey(bytes));
  }
  return panoramas;
}

// The columns moved to the right, around the circle: the camera turned counter-clockwise.
inline cv::Mat Rolled(const cv::Mat& image, int columns) {
  const int n = ((columns % image.cols) + image.cols) % image.cols;
  cv::Mat rolled;
  cv::hconcat(image.colRange(image.cols - n, image.cols), image.colRange(0, image.cols - n),
              rolled);
  return n == 0 ? image.clone() : rolled;
}

}  // namespace waystone
