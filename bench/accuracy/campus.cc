// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <deque>
#include <iostream>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "bench/accuracy/common.h"
#include "bench/accuracy/look_alike_buildings.h"
#include "bench/accuracy/stopwatch.h"
#include "bench/accuracy/world_source.h"
#include "builder/sources/memory_source.h"
#include "core/base/error.h"
#include "localizer/localizer.h"

namespace waystone::bench {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kVisits = 2;    // of each building, one sequence each
constexpr int kQueries = 5;   // of each building
constexpr int kFirst = 1001;  // buildings that nothing was fitted to

// A building and the walks through it.
struct Building {
  explicit Building(int number) : world(StoreyOf(number, 0)), queries(QueryTour(world, number)) {
    for (int visit = 0; visit < kVisits; ++visit) walks.push_back(MapTour(world, visit + 1));
  }

  World world;
  std::vector<Walk> walks;
  Walk queries;
};

// The buildings used last: all of them don't fit into memory. Thread-safe.
class Buildings {
 public:
  std::shared_ptr<const Building> Get(int number) {
    const std::scoped_lock lock(mutex_);
    for (const auto& [held, building] : held_) {
      if (held == number) return building;
    }
    if (held_.size() == kHeld) held_.pop_front();
    held_.emplace_back(number, std::make_shared<const Building>(number));
    return held_.back().second;
  }

 private:
  static constexpr size_t kHeld = 2;

  std::mutex mutex_;
  std::deque<std::pair<int, std::shared_ptr<const Building>>> held_;
};

// A visit of a building, whose images are rendered when they are read.
std::unique_ptr<Source> OpenVisit(Buildings& buildings, const Renderer& renderer, int number,
                                  int visit) {
  MemorySequence sequence;
  sequence.name = "building " + std::to_string(number) + " visit " + std::to_string(visit);
  for (int i = 0; i < kTourFrames; ++i) {
    sequence.frames.emplace_back(FrameInfo{i, std::to_string(i), {}}, [=, &buildings, &renderer] {
      const auto building = buildings.Get(number);
      const uint64_t seed = (static_cast<uint64_t>(number) * kVisits + visit) * kTourFrames + i;
      return Photograph(renderer, building->world,
                        building->walks[visit].frames[i].world_from_camera, seed);
    });
  }
  return std::make_unique<MemorySource>(std::move(sequence));
}

// Sequences of the map are the visits, in their order.
int BuildingOf(const Keyframe& keyframe) {
  return static_cast<int>(keyframe.sequence.value - 1) / kVisits;
}

int LinksAcross(const MapIndex& index) {
  int across = 0;
  for (const KeyframeLink& link : index.map().links) {
    across += BuildingOf(*index.FindKeyframe(link.a)) != BuildingOf(*index.FindKeyframe(link.b));
  }
  return across;
}

Json AskAll(Buildings& buildings, const Renderer& renderer, const MapIndex& index, int count) {
  int localized = 0;
  int right = 0;
  int ambiguous = 0;
  int asked = 0;
  std::vector<double> extract_ms;
  std::vector<double> search_ms;
  for (int b = 0; b < count; ++b) {
    const auto building = buildings.Get(kFirst + b);
    for (const WalkFrame& frame : SpreadOver(building->queries, kQueries).frames) {
      const cv::Mat photo = Photograph(renderer, building->world, frame.world_from_camera,
                                       static_cast<uint64_t>(++asked) + 5'000'000);
      const Stopwatch watch;
      const Features features = ExtractFeatures(photo, BuildOptions{}.features);
      extract_ms.push_back(1000 * watch.cpu_s());
      const Answer answer = LocalizeFeatures(index, features, {});
      search_ms.push_back(answer.timing.total_ms);
      ambiguous += answer.verdict == Verdict::kAmbiguous;
      if (answer.verdict != Verdict::kLocalized) continue;
      ++localized;
      right += BuildingOf(*index.FindKeyframe(answer.planes.keyframe->id)) == b;
    }
  }
  return {{"asked", asked},
          {"localized", localized},
          {"right", right},
          {"ambiguous", ambiguous},
          {"median_extract_ms", Quantile(extract_ms, 0.5)},
          {"median_query_ms", Quantile(search_ms, 0.5)}};
}

Json BuildAndAsk(int count) {
  const Renderer renderer(LookAlikeCamera(640));
  Buildings buildings;
  std::vector<std::unique_ptr<Source>> sources;
  for (int b = 0; b < count; ++b) {
    for (int visit = 0; visit < kVisits; ++visit) {
      sources.push_back(OpenVisit(buildings, renderer, kFirst + b, visit));
    }
  }
  const BuildResult built = BuildMap(sources, {}, {});
  const double peak_mb = PeakMb();
  const auto index = MapIndex::Build(built.map);
  const PlaneReport& report = built.report.planes.value();
  Json json{{"buildings", count},
            {"frames", report.frames},
            {"keyframes", built.map.keyframes.size()},
            {"planes", built.map.planes.size()},
            {"links", built.map.links.size()},
            {"links_across", LinksAcross(*index)},
            {"add_s", report.add_s},
            {"fusion_s", report.fusion_s},
            {"calibrate_s", report.calibrate_s},
            {"peak_mb", peak_mb}};
  json.update(AskAll(buildings, renderer, *index, count));
  std::cout << json.dump() << std::endl;
  return json;
}

}  // namespace

int RunCampus(const Args& args) {
  if (args.empty()) throw MapError(ErrorCode::kUsage, "campus wants numbers of buildings");
  Json json{{"bench", "campus"}, {"runs", Json::array()}};
  for (const std::string& count : args) json["runs"].push_back(BuildAndAsk(std::stoi(count)));
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
