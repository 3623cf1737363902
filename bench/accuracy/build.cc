// SPDX-License-Identifier: Apache-2.0
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <iostream>

#include "bench/accuracy/common.h"
#include "bench/accuracy/feature_layer.h"
#include "bench/accuracy/stopwatch.h"
#include "builder/frames/frame_pipeline.h"
#include "core/base/error.h"

namespace waystone::bench {
namespace {

struct StageCost {
  double wall_s = 0;
  double cpu_s = 0;
};

// One length of the sources: extraction alone and the whole build.
struct Run {
  int frames = 0;
  StageCost extraction;
  StageCost build;
  PlaneReport report;
  int64_t map_bytes = 0;
  double peak_mb = 0;
};

std::vector<std::unique_ptr<Source>> OpenAll(const Args& paths, int frames) {
  std::vector<std::unique_ptr<Source>> sources;
  for (const std::string& path : paths) {
    SourceOptions options;
    if (frames > 0) options.to = frames - 1;
    sources.push_back(OpenSource(path, options));
  }
  return sources;
}

StageCost ExtractAlone(const Args& paths, int frames) {
  const auto sources = OpenAll(paths, frames);
  const BuildOptions options;
  const Stopwatch watch;
  std::vector<Source*> all;
  for (const auto& source : sources) all.push_back(source.get());
  FeatureLayer layer(options.features, [](const ExtractedFrame&) {});
  BuildLayer(all, layer);
  return {watch.wall_s(), watch.cpu_s()};
}

// About the bytes that a map holds in memory: those of its blobs.
int64_t BytesOf(const MapData& map) {
  int64_t bytes = 0;
  for (const Keyframe& keyframe : map.keyframes) {
    bytes += static_cast<int64_t>(sizeof(Keyframe)) + std::ssize(keyframe.picture);
  }
  for (const Plane& plane : map.planes) {
    bytes += std::ssize(plane.features) * static_cast<int64_t>(sizeof(PlaneFeature)) +
             std::ssize(plane.descriptors.data()) +
             std::ssize(plane.views) * static_cast<int64_t>(sizeof(PlaneView));
  }
  return bytes;
}

void BuildOnce(const Args& paths, int frames, Run& run) {
  const auto sources = OpenAll(paths, frames);
  const Stopwatch watch;
  const BuildResult built = BuildMap(sources, BuildOptions{}, {});
  run.build = {watch.wall_s(), watch.cpu_s()};
  run.report = built.report.planes.value();
  run.frames = run.report.frames;
  run.map_bytes = BytesOf(built.map);
}

nlohmann::ordered_json ToJson(const Run& run) {
  const PlaneReport& report = run.report;
  return {{"frames", run.frames},
          {"extraction_s", run.extraction.wall_s},
          {"extraction_cpu_s", run.extraction.cpu_s},
          {"build_s", run.build.wall_s},
          {"build_cpu_s", run.build.cpu_s},
          {"ratio", run.build.wall_s / run.extraction.wall_s},
          {"cpu_ratio", run.build.cpu_s / run.extraction.cpu_s},
          {"choose_s", report.choose_s},
          {"planes_s", report.add_s - report.choose_s},
          {"fusion_s", report.fusion_s},
          {"map_mb", static_cast<double>(run.map_bytes) / 1e6},
          {"peak_mb", run.peak_mb}};
}

// Extraction is measured before and after the build: what else the machine does then affects both
// alike. It holds only a few frames, so the peak is the build's.
Run Measure(const Args& paths, int frames) {
  Run run;
  const StageCost before = ExtractAlone(paths, frames);
  BuildOnce(paths, frames, run);
  run.peak_mb = PeakMb();
  const StageCost after = ExtractAlone(paths, frames);
  run.extraction = {(before.wall_s + after.wall_s) / 2, (before.cpu_s + after.cpu_s) / 2};
  return run;
}

// In a process of its own, since a process's peak memory only grows. The measurements come through
// a pipe.
nlohmann::ordered_json MeasureApart(const Args& paths, int frames) {
  int ends[2];
  if (pipe(ends) != 0) throw MapError(ErrorCode::kInternal, "no pipe");
  const pid_t child = fork();
  if (child < 0) throw MapError(ErrorCode::kInternal, "no process");
  if (child == 0) {
    std::string text;
    try {
      text = ToJson(Measure(paths, frames)).dump();
    } catch (const std::exception& error) {
      text = nlohmann::json({{"error", error.what()}}).dump();
    }
    const bool written = write(ends[1], text.data(), text.size()) == std::ssize(text);
    _exit(written ? 0 : 1);
  }
  close(ends[1]);
  std::string text;
  char buffer[4096];
  for (ssize_t got = 0; (got = read(ends[0], buffer, sizeof buffer)) > 0;) text.append(buffer, got);
  close(ends[0]);
  waitpid(child, nullptr, 0);
  auto json = nlohmann::ordered_json::parse(text, nullptr, false);
  if (json.is_discarded()) throw MapError(ErrorCode::kInternal, "the measuring process failed");
  if (json.contains("error")) throw MapError(ErrorCode::kBadSource, json["error"]);
  return json;
}

std::vector<int> ParseCounts(const std::string& text) {
  std::vector<int> counts = ParseNumbers(text, ',');
  if (counts.empty() || std::ranges::min(counts) < 1) {
    throw MapError(ErrorCode::kUsage, "'" + text + "' are no counts; write --frames 250,500");
  }
  return counts;
}

}  // namespace

int RunBuild(const Args& raw) {
  Args args = raw;
  const std::string counts = TakeOption(args, "frames", "");
  if (args.empty()) throw MapError(ErrorCode::kUsage, "build wants one source at least");
  const std::vector<int> lengths = counts.empty() ? std::vector<int>{0} : ParseCounts(counts);
  nlohmann::ordered_json json = {{"bench", "build"}, {"runs", nlohmann::ordered_json::array()}};
  std::printf(
      "frames  extraction s (cpu)    build s (cpu)  ratio (cpu)  choice s  planes s  "
      "fusion s  map MB  peak MB\n");
  for (int frames : lengths) {
    const nlohmann::ordered_json run = MeasureApart(args, frames);
    const auto number = [&](const char* key) { return run[key].get<double>(); };
    std::printf(
        "%6d  %8.1f (%7.1f)  %8.1f (%6.1f)  %5.2f (%4.2f)  %8.2f  %8.2f  %8.2f  %6.2f  "
        "%7.0f\n",
        run["frames"].get<int>(), number("extraction_s"), number("extraction_cpu_s"),
        number("build_s"), number("build_cpu_s"), number("ratio"), number("cpu_ratio"),
        number("choose_s"), number("planes_s"), number("fusion_s"), number("map_mb"),
        number("peak_mb"));
    (void)std::fflush(stdout);
    json["runs"].push_back(run);
  }
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
