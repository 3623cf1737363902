// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "tests/e2e/shared_map.h"
#include "world/render.h"
#include "world/rig.h"
#include "world/walk.h"
#include "world/world.h"

namespace waystone {

namespace fs = std::filesystem;

// A folder for the files of a test of commands on panoramas.
class PanoramaCommands : public testing::Test {
 protected:
  ~PanoramaCommands() override { fs::remove_all(folder_); }

  static const World& Hall() {
    static const World world = [] {
      WorldOptions options;
      options.texel_m = 0.02;
      return World(DemoPlan(), options);
    }();
    return world;
  }

  // Writes a panorama with this yaw.
  fs::path Write(const std::string& name, double yaw_rad) const {
    const Renderer renderer(PanoramaCamera(256));
    fs::path path = folder_ / name;
    cv::imwrite(path.string(),
                renderer.Render(Hall(), WorldFromCamera({6.5, 10.5, 1.5}, yaw_rad)).grey);
    return path;
  }

  const fs::path folder_ = FreshFolder();
};

// A walk of panoramas through a room and its map, made once.
class PanoramaMap : public PanoramaCommands {
 protected:
  static constexpr int kPanoramas = 12;

  static void SetUpTestSuite() {
    home_ = FreshFolder();
    fs::create_directory(home_ / "walk");
    for (int i = 0; i < kPanoramas; ++i) Draw(home_ / "walk" / (std::to_string(i) + ".png"), i);
    for (const double at : {2.5, 3.5, 4.5}) {
      Draw(home_ / ("query" + std::to_string(static_cast<int>(at)) + ".png"), at);
    }
    build_ = RunWaystone({"build", home_ / "walk", "-o", home_ / "hall.db", "--json"});
  }
  static void TearDownTestSuite() { fs::remove_all(home_); }

  // What is seen after so many steps of the walk.
  static void Draw(const fs::path& path, double step) {
    const Renderer renderer(PanoramaCamera(256));
    RenderOptions noisy;
    noisy.noise_sigma = 2;
    noisy.noise_seed = static_cast<uint64_t>(10 * step) + 1;
    const auto pose = WorldFromCamera({5.6 + 0.2 * step, 10.5, 1.5}, 0.05 * step);
    cv::imwrite(path.string(), renderer.Render(Hall(), pose, noisy).grey);
  }

  // A photo to the front after so many steps, 80 degrees wide.
  static void DrawPhoto(const fs::path& path, double step) {
    const Renderer renderer(PinholeCamera(320, 240, 80 / 57.29578));
    const auto pose = WorldFromCamera({5.6 + 0.2 * step, 10.5, 1.5}, 0.05 * step);
    cv::imwrite(path.string(), renderer.Render(Hall(), pose).grey);
  }

  static fs::path Query(int step) { return home_ / ("query" + std::to_string(step) + ".png"); }

  static inline fs::path home_;
  static inline RunResult build_;
};

}  // namespace waystone
