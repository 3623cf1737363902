// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "builder/build_map.h"
#include "core/base/error.h"
#include "world/render.h"
#include "world/rig.h"
#include "world/walk.h"
#include "world/world.h"

namespace waystone {

// A made building and the first steps of a walk through it, rendered once for all tests.
struct Stage {
  World world{DemoPlan(), WorldOptions{.texture_richness = 0.5}};
  Walk walk;
  Renderer renderer{PinholeCamera(320, 240, 1.2)};
  std::vector<cv::Mat> frames;

  Stage() {
    WalkOptions options;
    options.step_m = 0.1;
    walk = DemoWalk(world.plan(), options);
    walk.frames.resize(45);
    for (const WalkFrame& frame : walk.frames) {
      frames.push_back(renderer.Render(world, frame.world_from_camera).grey);
    }
  }
};

inline const Stage& TheStage() {
  static const Stage stage;
  return stage;
}

// Frames from memory; the numbers in `broken` can't be decoded.
class MemorySource : public Source {
 public:
  MemorySource(int frames, std::set<int> broken, std::optional<Camera> camera = {})
      : frames_(frames), broken_(std::move(broken)), camera_(std::move(camera)) {}

  const std::string& kind() const override { return kind_; }
  const std::string& name() const override { return name_; }
  int size() const override { return frames_; }
  const std::optional<Camera>& camera() const override { return camera_; }
  std::string Announcement() const override { return "Frames in memory"; }
  std::optional<EncodedFrame> NextEncoded() override {
    if (next_ == frames_) return std::nullopt;
    const int frame = next_++;
    const bool broken = broken_.contains(frame);
    return EncodedFrame({frame, "frame " + std::to_string(frame), frame / 15.0}, [=] {
      if (broken) throw MapError(ErrorCode::kBadImage, "made unreadable");
      return TheStage().frames[frame];
    });
  }

 private:
  int frames_;
  std::set<int> broken_;
  int next_ = 0;
  std::string kind_ = "folder";
  std::string name_ = "memory";
  std::optional<Camera> camera_;
};

inline BuildResult Build(int threads, std::set<int> broken = {}, int frames = 45) {
  BuildOptions options;
  options.threads = threads;
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::make_unique<MemorySource>(frames, std::move(broken)));
  return BuildMap(sources, options, {});
}

inline const BuildResult& TheMap() {
  static const BuildResult result = Build(1);
  return result;
}

}  // namespace waystone
