// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "builder/sources/source.h"
#include "world/render.h"
#include "world/walk.h"
#include "world/world.h"

namespace waystone::bench {

// `count` frames of a walk, spread over all of it.
Walk SpreadOver(const Walk& walk, int count);

// Every n-th frame of a walk.
Walk EveryNth(const Walk& walk, int n);

// A rendered walk as a source: frames are rendered when others would be decoded.
class WorldSource : public Source {
 public:
  // All three must outlive it. Frames have the noise, blur and exposure of an ordinary camera.
  WorldSource(const World& world, const Renderer& renderer, const Walk& walk)
      : world_(world), renderer_(renderer), walk_(walk), camera_(renderer.camera()) {}

  const std::string& kind() const override { return kind_; }
  const std::string& name() const override { return name_; }
  int size() const override { return static_cast<int>(walk_.frames.size()); }
  const std::optional<Camera>& camera() const override { return camera_; }
  cv::Size frame_size() const override { return {camera_->width, camera_->height}; }
  std::string Announcement() const override { return "World walk"; }
  std::optional<EncodedFrame> NextEncoded() override;

  // The picture of a frame with its plane ids.
  RenderedFrame Render(int frame) const;

 private:
  const World& world_;
  const Renderer& renderer_;
  const Walk& walk_;
  std::string kind_ = "folder";
  std::string name_ = "world";
  std::optional<Camera> camera_;
  int next_ = 0;
};

}  // namespace waystone::bench
