// SPDX-License-Identifier: Apache-2.0
// The layers on several threads of our own: ThreadSanitizer can't see how oneTBB, which runs the
// pipeline, synchronizes its tasks.
#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <future>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "builder/frames/frame_pipeline.h"
#include "builder/layer_options.h"
#include "builder/orientation/orientation_layer.h"
#include "builder/sources/memory_source.h"
#include "core/image/opencv_errors.h"
#include "world/render.h"
#include "world/rig.h"
#include "world/walk.h"
#include "world/world.h"

namespace waystone {
namespace {

constexpr int kFrames = 8;
constexpr int kThreads = 3;

MemorySource OpenWalk(const Camera& camera) {
  static const World world(DemoPlan(), WorldOptions{.texel_m = 0.02, .texture_richness = 0.5});
  const Renderer renderer(camera);
  MemorySequence sequence{.name = "walk", .camera = camera};
  for (int i = 0; i < kFrames; ++i) {
    const auto pose = WorldFromCamera({5.6 + 0.1 * i, 10.5, 1.5}, 0.05 * i);
    sequence.frames.emplace_back(FrameInfo{i, "frame " + std::to_string(i), i / 15.0},
                                 [image = renderer.Render(world, pose).grey] { return image; });
  }
  return MemorySource(std::move(sequence));
}

// As the pipeline does it: observes frames on several threads, and adds them in their order while
// later ones are observed.
void ObserveOnThreads(LayerBuilder& layer, Source& source) {
  layer.StartSequence(SequenceId{1}, source);
  std::vector<Frame> frames;
  while (const std::optional<EncodedFrame> next = source.NextEncoded()) {
    frames.push_back(next->Decode());
  }
  std::vector<std::promise<std::unique_ptr<Observation>>> observed(frames.size());
  std::atomic<size_t> next = 0;
  std::vector<std::jthread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&] {
      for (size_t i = next++; i < frames.size(); i = next++) {
        observed[i].set_value(layer.Observe(frames[i]));
      }
    });
  }
  FrameReport report;
  ProgressReporter progress;
  for (size_t i = 0; i < frames.size(); ++i) {
    std::unique_ptr<Observation> observation = observed[i].get_future().get();
    report.Count(frames[i].info, observation->error);
    layer.Add(std::move(observation), progress);
  }
  layer.FinishSequence(report);
}

template <class Layer, class Options>
void ExpectSameOnThreads(const Options& options, const Camera& camera) {
  cv::setNumThreads(1);
  ThrowOpenCvErrors();
  tbb::task_arena(1).execute([&] {
    Layer alone(options);
    MemorySource source = OpenWalk(camera);
    const MapData expected = BuildLayer({&source}, alone);
    EXPECT_TRUE(!expected.keyframes.empty() || expected.appearance || expected.orientation);
    Layer layer(options);
    MemorySource again = OpenWalk(camera);
    ObserveOnThreads(layer, again);
    MapData map;
    map.sequences = expected.sequences;
    ProgressReporter progress;
    layer.Finish(map, progress);
    EXPECT_TRUE(map == expected);
  });
}

TEST(Observe, OfPlanesIsThreadSafe) {
  ExpectSameOnThreads<PlaneLayerBuilder>(MakePlaneOptions({}), PinholeCamera(320, 240, 1.2));
}

TEST(Observe, OfPanoramasIsThreadSafe) {
  ExpectSameOnThreads<AppearanceLayerBuilder>(MakeAppearanceOptions({}), PanoramaCamera(256));
}

TEST(Observe, OfDirectionsIsThreadSafe) {
  ExpectSameOnThreads<OrientationLayerBuilder>(MakeOrientationOptions({}),
                                               PinholeCamera(320, 240, 1.2));
}

}  // namespace
}  // namespace waystone
