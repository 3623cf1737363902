// SPDX-License-Identifier: Apache-2.0
// waystone-speed: times of the functions in which queries and builds spend most of theirs, by
// Google Benchmark. `waystone-speed --benchmark_filter=Compass` runs some of them.
#include <benchmark/benchmark.h>

#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/features/features.h"
#include "core/features/match.h"
#include "core/features/packed_rows.h"
#include "core/homography/homography.h"
#include "core/image/decode.h"
#include "core/panorama/fourier_signature.h"
#include "core/panorama/visual_compass.h"
#include "world/render.h"
#include "world/rig.h"
#include "world/walk.h"
#include "world/world.h"

namespace waystone::bench {
namespace {

constexpr FeatureType kTypes[] = {FeatureType::kSift, FeatureType::kOrb, FeatureType::kAkaze};

// Those of SIFT are about as long as extracted ones.
Descriptors RandomDescriptors(FeatureType type, int rows, Random& random) {
  const int levels = type == FeatureType::kSift ? 40 : 256;
  std::vector<uint8_t> bytes(static_cast<size_t>(rows) * DescriptorBytes(type));
  for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random.Below(levels));
  return {DescriptorBytes(type), std::move(bytes)};
}

// One descriptor against 128 others, by each implementation that this processor can run.
void Distances(benchmark::State& state, FeatureType type, PackedDistancesFunction function) {
  constexpr int kRows = 128;
  Random random(1);
  const PackedQuery query(type, RandomDescriptors(type, 1, random).row(0));
  const PackedRows rows(type, RandomDescriptors(type, kRows, random));
  std::vector<int32_t> distances(kRows);
  std::vector<uint8_t> near(rows.blocks());
  for ([[maybe_unused]] const auto iteration : state) {
    function(query, rows, 0, rows.blocks(), 0, distances.data(), near.data());
    benchmark::DoNotOptimize(distances.data());
  }
  state.SetItemsProcessed(state.iterations() * kRows);
}

// Two images of 1000 features, in both directions with the ratio test.
void MatchImages(benchmark::State& state, FeatureType type) {
  constexpr int kFeatures = 1000;
  Random random(2);
  const Descriptors a = RandomDescriptors(type, kFeatures, random);
  const Descriptors b = RandomDescriptors(type, kFeatures, random);
  for ([[maybe_unused]] const auto iteration : state)
    benchmark::DoNotOptimize(MatchDescriptors(a, b, type, {}));
}

// Pairs of points on a plane of two images, half a pixel of noise.
PointPairs PlanePairs(int count) {
  Eigen::Matrix3d b_from_a;
  b_from_a << 0.95, 0.08, 12, -0.05, 1.03, -7, 1e-5, -4e-5, 1;
  Random random(3);
  const auto noise = [&random]() -> Eigen::Vector2d {
    const double x = random.Normal();
    const double y = random.Normal();
    return {0.5 * x, 0.5 * y};
  };
  PointPairs pairs;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d a(random.Uniform() * 640, random.Uniform() * 480);
    pairs.Add(a + noise(), Apply(b_from_a, a) + noise());
  }
  return pairs;
}

void EstimateHomographyLinearly(benchmark::State& state) {
  const PointPairs pairs = PlanePairs(static_cast<int>(state.range(0)));
  for ([[maybe_unused]] const auto iteration : state)
    benchmark::DoNotOptimize(HomographyByDlt(pairs));
}

void RefineHomographyFromLinear(benchmark::State& state) {
  const PointPairs pairs = PlanePairs(static_cast<int>(state.range(0)));
  const Eigen::Matrix3d initial = HomographyByDlt(pairs).value();
  for ([[maybe_unused]] const auto iteration : state)
    benchmark::DoNotOptimize(RefineHomography(pairs, initial));
}

// A panorama in the demo building.
cv::Mat RenderPanorama(double x_m, double y_m, double yaw_rad) {
  constexpr int kWidth = 512;
  static const World world(DemoPlan(), [] {
    WorldOptions options;
    options.texel_m = 0.01;
    return options;
  }());
  static const Renderer renderer(PanoramaCamera(kWidth));
  return renderer.Render(world, WorldFromCamera({x_m, y_m, 1.5}, yaw_rad, 0)).grey;
}

void ComputeSignature(benchmark::State& state) {
  const cv::Mat panorama = RenderPanorama(6.5, 10.5, 0);
  for ([[maybe_unused]] const auto iteration : state) benchmark::DoNotOptimize(Signature(panorama));
}

void Compass(benchmark::State& state) {
  const FourierSignature a = Signature(RenderPanorama(6.5, 10.5, 0));
  const FourierSignature b = Signature(RenderPanorama(6.2, 10.3, std::numbers::pi / 3));
  for ([[maybe_unused]] const auto iteration : state)
    benchmark::DoNotOptimize(RelativeHeading(a, b));
}

void Decode(benchmark::State& state, const char* extension) {
  const cv::Mat panorama = RenderPanorama(6.5, 10.5, 0);
  std::vector<uint8_t> bytes;
  cv::imencode(extension, panorama, bytes);
  for ([[maybe_unused]] const auto iteration : state) benchmark::DoNotOptimize(DecodeGrey(bytes));
  state.SetBytesProcessed(state.iterations() * static_cast<int64_t>(panorama.total()));
}

void RegisterKernels() {
  for (const FeatureType type : kTypes) {
    const std::string name(NameOf(type));
    for (const NamedPackedDistances& each : RunnablePackedDistances()) {
      benchmark::RegisterBenchmark(("Distances/" + name + "/" + each.name).c_str(), Distances, type,
                                   each.function);
    }
    benchmark::RegisterBenchmark(("MatchImages/" + name).c_str(), MatchImages, type)
        ->Unit(benchmark::kMillisecond);
  }
  for (const char* extension : {".jpg", ".png"}) {
    benchmark::RegisterBenchmark((std::string("Decode/") + extension).c_str(), Decode, extension)
        ->Unit(benchmark::kMicrosecond);
  }
}

BENCHMARK(EstimateHomographyLinearly)->Arg(20)->Arg(200)->Unit(benchmark::kMicrosecond);
BENCHMARK(RefineHomographyFromLinear)->Arg(20)->Arg(200)->Unit(benchmark::kMicrosecond);
BENCHMARK(ComputeSignature)->Unit(benchmark::kMillisecond);
BENCHMARK(Compass)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace waystone::bench

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  waystone::bench::RegisterKernels();
  benchmark::RunSpecifiedBenchmarks();
}
