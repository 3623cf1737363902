// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <tbb/parallel_for.h>

#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <set>
#include <string>
#include <vector>

#include "builder/appearance/appearance_layer.h"
#include "builder/frames/frame_pipeline.h"
#include "builder/sources/memory_source.h"
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

// Panoramas or photos as a source.
inline MemorySource ImagesSource(const std::vector<cv::Mat>& images,
                                 const std::string& name = "drive") {
  MemorySequence sequence{.name = name,
                          .frame_size = images.empty() ? cv::Size() : images[0].size()};
  for (size_t i = 0; i < images.size(); ++i) {
    sequence.frames.emplace_back(FrameInfo{static_cast<int>(i), "image " + std::to_string(i), {}},
                                 [image = images[i]] { return image; });
  }
  return MemorySource(std::move(sequence));
}

inline std::vector<cv::Mat> FirstPanoramas(int count) {
  const auto& all = TheDrive().panoramas;
  return {all.begin(), all.begin() + count};
}

// Options that are fast and suit the drive.
inline AppearanceOptions ShortDrive() {
  AppearanceOptions options;
  options.loops.min_gap = 20;
  options.odometry.max_span = 1;
  return options;
}

// The appearance layer of sources and what its builder tells about it.
struct BuiltAppearance {
  AppearanceLayer layer;
  std::vector<Sequence> sequences;
  AppearanceReport report;
};

inline BuiltAppearance BuildAppearance(const std::vector<Source*>& sources,
                                       const AppearanceOptions& options = {},
                                       const ProgressCallback& progress = {}) {
  AppearanceLayerBuilder builder(options);
  MapData map = BuildLayer(sources, builder, progress);
  return {std::move(*map.appearance), std::move(map.sequences), builder.report()};
}

inline BuiltAppearance BuildFromImages(const std::vector<cv::Mat>& images,
                                       const AppearanceOptions& options = ShortDrive()) {
  MemorySource source = ImagesSource(images);
  return BuildAppearance({&source}, options);
}

}  // namespace waystone
