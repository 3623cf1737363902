// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "builder/build_map.h"
#include "builder/sources/memory_source.h"
#include "core/base/error.h"
#include "world/render.h"
#include "world/rig.h"
#include "world/walk.h"
#include "world/world.h"

namespace waystone {

// A made building and the first steps of a walk through it, rendered once for all tests.
struct MadeStage {
  World world{DemoPlan(), WorldOptions{.texture_richness = 0.5}};
  Walk walk;
  Renderer renderer{PinholeCamera(320, 240, 1.2)};
  std::vector<cv::Mat> frames;

  MadeStage() {
    WalkOptions options;
    options.step_m = 0.1;
    walk = DemoWalk(world.plan(), options);
    walk.frames.resize(45);
    for (const WalkFrame& frame : walk.frames) {
      frames.push_back(renderer.Render(world, frame.world_from_camera).grey);
    }
  }
};

inline const MadeStage& TheStage() {
  static const MadeStage stage;
  return stage;
}

// The first frames of the walk; the numbers in `broken` can't be decoded.
inline std::unique_ptr<Source> OpenStage(int frames, const std::set<int>& broken = {},
                                         std::optional<Camera> camera = {}) {
  MemorySequence sequence{.name = "memory", .camera = std::move(camera)};
  for (int i = 0; i < frames; ++i) {
    const bool sound = !broken.contains(i);
    sequence.frames.emplace_back(FrameInfo{i, "frame " + std::to_string(i), i / 15.0}, [=] {
      if (!sound) throw MapError(ErrorCode::kBadImage, "made unreadable");
      return TheStage().frames[i];
    });
  }
  return std::make_unique<MemorySource>(std::move(sequence));
}

inline BuildResult Build(int threads, const std::set<int>& broken = {}, int frames = 45) {
  BuildOptions options;
  options.threads = threads;
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(OpenStage(frames, broken));
  return BuildMap(sources, options, {});
}

inline const BuildResult& TheMap() {
  static const BuildResult result = Build(1);
  return result;
}

}  // namespace waystone
