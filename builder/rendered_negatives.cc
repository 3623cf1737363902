// SPDX-License-Identifier: Apache-2.0
#include "builder/rendered_negatives.h"

#include <tbb/parallel_for.h>

#include "world/render.h"
#include "world/rig.h"
#include "world/walk.h"
#include "world/world.h"

namespace waystone {
namespace {

constexpr uint64_t kSeed = 0x57415953544f4e45;  // of no building that users render

}  // namespace

std::vector<Features> RenderedNegatives(int count, const FeatureOptions& options) {
  std::vector<Features> features(count);
  if (count == 0) return features;
  WorldOptions world_options;
  world_options.seed = kSeed;
  const World world(OtherPlan(), world_options);
  const Walk walk = DemoWalk(world.plan());
  const Renderer renderer(PinholeCamera(640, 480, 1.2));
  tbb::parallel_for(0, count, [&](int i) {
    const size_t frame = walk.frames.size() * i / count;
    RenderOptions render;
    render.noise_sigma = 3;
    render.noise_seed = kSeed + i;
    const RenderedFrame picture =
        renderer.Render(world, walk.frames[frame].world_from_camera, render);
    features[i] = ExtractFeatures(picture.grey, options);
  });
  return features;
}

}  // namespace waystone
