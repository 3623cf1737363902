// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/world_source.h"

namespace waystone::bench {

Walk SpreadOver(const Walk& walk, int count) {
  Walk chosen;
  const auto all = static_cast<double>(walk.frames.size());
  for (int i = 0; i < count; ++i) {
    chosen.frames.push_back(walk.frames[static_cast<size_t>(all * (i + 0.5) / count)]);
  }
  return chosen;
}

Walk EveryNth(const Walk& walk, int n) {
  Walk chosen;
  for (size_t i = 0; i < walk.frames.size(); i += n) chosen.frames.push_back(walk.frames[i]);
  return chosen;
}

RenderedFrame WorldSource::Render(int frame) const {
  RenderOptions options;
  options.lens_blur_px = 0.6;
  options.noise_sigma = 3;
  options.noise_seed = static_cast<uint64_t>(frame) + 1;
  options.exposure_gain = frame % 40 < 20 ? 1.0 : 0.85;
  return renderer_.Render(world_, walk_.frames[frame].world_from_camera, options);
}

std::optional<EncodedFrame> WorldSource::NextEncoded() {
  if (next_ >= size()) return std::nullopt;
  const int frame = next_++;
  const FrameInfo info{frame, "frame " + std::to_string(frame), walk_.frames[frame].time_s};
  return EncodedFrame(info, [this, frame] { return Render(frame).grey; });
}

}  // namespace waystone::bench
