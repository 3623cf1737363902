// SPDX-License-Identifier: Apache-2.0
#include "builder/calibration/rendered_negatives.h"

#include <tbb/parallel_for.h>

#include <mutex>

#include "world/render.h"
#include "world/rig.h"
#include "world/walk.h"
#include "world/world.h"

namespace waystone {
namespace {

constexpr uint64_t kSeed = 0x57415953544f4e45;  // of no building that users render

// Pictures along a walk through the building, by a camera. A panorama's pixels are coarser than a
// photo's, so the textures may be, too.
std::vector<cv::Mat> Pictures(int count, const Camera& camera, double texel_m) {
  std::vector<cv::Mat> pictures(count);
  if (count == 0) return pictures;
  WorldOptions world_options;
  world_options.seed = kSeed;
  world_options.texel_m = texel_m;
  const World world(OtherPlan(), world_options);
  const Walk walk = DemoWalk(world.plan());
  const Renderer renderer(camera);
  tbb::parallel_for(0, count, [&](int i) {
    const size_t frame = walk.frames.size() * i / count;
    RenderOptions render;
    render.noise_sigma = 3;
    render.noise_seed = kSeed + i;
    pictures[i] = renderer.Render(world, walk.frames[frame].world_from_camera, render).grey;
  });
  return pictures;
}

bool AreSame(const FeatureOptions& a, const FeatureOptions& b) {
  return FeatureOptions::Fields(
      [&](const auto&... field) { return (... && (a.*field.member == b.*field.member)); });
}

// The last rendered features.
struct LastNegatives {
  std::mutex mutex;
  int count = -1;
  FeatureOptions options;
  std::vector<Features> features;
};

}  // namespace

std::vector<Features> RenderNegatives(int count, const FeatureOptions& options) {
  const std::vector<cv::Mat> pictures =
      Pictures(count, PinholeCamera(640, 480, 1.2), WorldOptions{}.texel_m);
  std::vector<Features> features(count);
  tbb::parallel_for(0, count, [&](int i) { features[i] = ExtractFeatures(pictures[i], options); });
  return features;
}

std::vector<Features> CachedNegatives(int count, const FeatureOptions& options) {
  static LastNegatives last;
  {
    const std::lock_guard lock(last.mutex);
    if (last.count == count && AreSame(last.options, options)) return last.features;
  }
  // Without the lock: while a thread waits for TBB, it may run a task that comes here, too.
  std::vector<Features> features = RenderNegatives(count, options);
  const std::lock_guard lock(last.mutex);
  last.count = count;
  last.options = options;
  last.features = features;
  return features;
}

std::vector<cv::Mat> RenderedPanoramas(int count, int width_px) {
  constexpr double kTexel_m = 0.015;
  return Pictures(count, PanoramaCamera(width_px), kTexel_m);
}

}  // namespace waystone
