// SPDX-License-Identifier: Apache-2.0
#include <tbb/task_arena.h>

#include <cstdio>
#include <fstream>
#include <iostream>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <optional>

#include "bench/accuracy/common.h"
#include "bench/accuracy/scale_map.h"
#include "bench/accuracy/world_source.h"
#include "bench/baseline/scenes.h"
#include "cli/system/child_process.h"
#include "core/base/clock.h"
#include "core/base/error.h"
#include "localizer/planes/locate.h"
#include "schema/file/map_store.h"
#include "schema/layers/planes/index_features.h"
#include "world/rig.h"

namespace waystone::bench {
namespace {

namespace fs = std::filesystem;

constexpr int kMapFrames = 300;         // of the walk that is mapped
constexpr int kQueryStep = 5;           // frames of the other walk between queries
constexpr int kExhaustiveQueries = 30;  // that are repeated without the index
constexpr double kRight_px = 10;        // a homography that is farther from the truth is wrong

int64_t ResidentBytes() {
  std::ifstream statm("/proc/self/statm");
  int64_t total = 0;
  int64_t resident = 0;
  statm >> total >> resident;
  return resident * sysconf(_SC_PAGESIZE);
}

// Opens a map as a server does, in a process of its own so that memory isn't reused.
int OpenOnly(const std::string& path) {
  const int64_t before = ResidentBytes();
  const Clock::time_point start = Clock::now();
  const auto index = MapIndex::Build(ReadMap(path, {.images = false}));
  const double open_s = SecondsSince(start);
  std::cout << nlohmann::json{{"open_s", open_s}, {"bytes", ResidentBytes() - before}} << std::endl;
  return index->search().rows() > 0 ? 0 : 1;
}

nlohmann::json OpenElsewhere(const fs::path& map) {
  ChildProcess child({ThisProgram(), "scale", "--open", map.string()}, true);
  const std::string text = child.ReadLine();
  if (child.Wait() != 0) throw MapError(ErrorCode::kInternal, "can't open " + map.string());
  return nlohmann::json::parse(text);
}

struct Query {
  std::vector<uint8_t> bytes;  // JPEG
  Eigen::Isometry3d world_from_camera;
  RenderedFrame frame;
};

// A made building, a walk through it that is mapped, and photos from another walk on the same way.
class MappedWorld {
 public:
  MappedWorld()
      : world_(DemoPlan()),
        renderer_(PinholeCamera(640, 480, 1.2)),
        walk_(MakeWalk(WalkOptions{})) {
    std::vector<std::unique_ptr<Source>> sources;
    sources.push_back(std::make_unique<WorldSource>(world_, renderer_, walk_));
    BuildOptions options;
    options.images = false;
    map_ = BuildMap(sources, options, {}).map;
    MakeQueries();
  }

  const MapData& map() const { return map_; }
  const std::vector<Query>& queries() const { return queries_; }

  // Whether the answer's inliers are where it says, by the world's truth.
  bool IsRight(const MapIndex& index, const Query& query, const Answer& answer) const {
    const SceneAnswer place = SceneAnswerOf(index, answer);
    const std::optional<double> error =
        WorldError(world_, renderer_.camera(), query.frame, query.world_from_camera,
                   walk_.frames[place.reference_frame].world_from_camera, place);
    return error && *error <= kRight_px;
  }

 private:
  Walk MakeWalk(WalkOptions options) const {
    options.step_m = 0.1;
    Walk walk = DemoWalk(world_.plan(), options);
    if (std::ssize(walk.frames) > kMapFrames) walk.frames.resize(kMapFrames);
    return walk;
  }

  void MakeQueries() {
    WalkOptions other;
    other.seed = 2;
    other.height_m = 1.4;
    other.gaze_offset_rad = 0.1;
    const Walk walk = MakeWalk(other);
    const WorldSource source(world_, renderer_, walk);
    for (int frame = 0; frame < std::ssize(walk.frames); frame += kQueryStep) {
      Query query{{}, walk.frames[frame].world_from_camera, source.Render(frame)};
      cv::imencode(".jpg", query.frame.grey, query.bytes, {cv::IMWRITE_JPEG_QUALITY, 90});
      queries_.push_back(std::move(query));
    }
  }

  World world_;
  Renderer renderer_;
  Walk walk_;
  MapData map_;
  std::vector<Query> queries_;
};

// What queries of a map with the index gave.
struct Timed {
  std::vector<double> floor_ms, shortlist_ms, verify_ms, total_ms, ratio;
  std::vector<Answer> answers;
  int localized = 0;
  int right = 0;
};

Timed AskAll(const MappedWorld& scene, const MapIndex& index) {
  Timed timed;
  for (const Query& query : scene.queries()) {
    const Answer answer = Localize(index, query.bytes, "", LocalizeOptions{});
    const StageTimes& t = answer.timing;
    const double floor = t.decode_ms + t.extract_ms;
    timed.floor_ms.push_back(floor);
    timed.shortlist_ms.push_back(t.shortlist_ms);
    timed.verify_ms.push_back(t.verify_ms);
    timed.total_ms.push_back(t.total_ms);
    timed.ratio.push_back(t.total_ms / floor);
    const bool localized = answer.verdict == Verdict::kLocalized;
    timed.localized += localized;
    timed.right += localized && scene.IsRight(index, query, answer);
    timed.answers.push_back(answer);
  }
  return timed;
}

// The index against exhaustive search.
struct Comparison {
  int localized = 0;     // queries that exhaustive search localizes
  int found = 0;         // of them, with the same keyframe and best plane through the index
  int64_t features = 0;  // of the queries
  int64_t nearest = 0;   // of them, those that got their true nearest neighbour
  int64_t distinct = 0;  // features whose nearest plane stands out: those that can match
  int64_t distinct_nearest = 0;
  double exhaustive_ms = 0;  // a query, shortlist alone
};

void CompareNearest(const MapIndex& index, const Features& query, Comparison& sum) {
  const LocalizeOptions options;
  const auto& search = index.search();
  const Clock::time_point start = Clock::now();
  const auto truth = search.Nearest(query.descriptors, 2, search.lists());
  sum.exhaustive_ms += 1000 * SecondsSince(start);
  const auto found = search.Nearest(query.descriptors, 2, options.planes.probes);
  for (size_t i = 0; i < truth.size(); i += 2) {
    const bool same = found[i].distance == truth[i].distance;
    const bool distinct = PassesRatio(query.type, truth[i].distance, truth[i + 1].distance,
                                      options.planes.match.max_ratio);
    ++sum.features;
    sum.nearest += same;
    sum.distinct += distinct;
    sum.distinct_nearest += distinct && same;
  }
}

// Of a localized answer; nothing for a place without planes.
std::optional<PlaneId> BestPlane(const Answer& answer) {
  if (answer.planes.recognised.empty()) return std::nullopt;
  return answer.planes.recognised.front().id;
}

Comparison Compare(const MappedWorld& scene, const MapIndex& index, const Timed& timed) {
  Comparison sum;
  LocalizeOptions exhaustive;
  exhaustive.planes.probes = std::numeric_limits<int>::max();
  const int count = std::min<int>(kExhaustiveQueries, static_cast<int>(timed.answers.size()));
  for (int i = 0; i < count; ++i) {
    const size_t q = static_cast<size_t>(i) * timed.answers.size() / count;
    const cv::Mat grey = DecodeGrey(scene.queries()[q].bytes, exhaustive.limits);
    const Features features = ExtractFeatures(grey, QueryFeatureOptions(index, exhaustive.planes));
    CompareNearest(index, features, sum);
    const Answer truth = LocalizeFeatures(index, features, exhaustive);
    if (truth.verdict != Verdict::kLocalized) continue;
    ++sum.localized;
    const Answer& answer = timed.answers[q];
    sum.found += answer.verdict == Verdict::kLocalized &&
                 answer.planes.keyframe->id == truth.planes.keyframe->id &&
                 BestPlane(answer) == BestPlane(truth);
  }
  sum.exhaustive_ms /= std::max(1, count);
  return sum;
}

bool SameOnOneThread(const MapData& map) {
  tbb::task_arena one(1);
  return one.execute([&] { return IndexFeatures(map); }) == map.index;
}

nlohmann::ordered_json Measure(const MappedWorld& scene, int64_t features, const fs::path& file) {
  MapData map = Enlarged(scene.map(), features, 1);
  nlohmann::ordered_json json = {{"features", CountFeatures(map)},
                                 {"planes", map.planes.size()},
                                 {"keyframes", map.keyframes.size()}};
  const Clock::time_point start = Clock::now();
  const bool same = SameOnOneThread(map);
  json["index_build_s"] = SecondsSince(start);
  json["same_on_one_thread"] = same;
  json["lists"] = map.index ? map.index->centres.rows() : 0;
  json["index_bytes"] =
      map.index ? map.index->centres.data().size() + 2 * map.index->list_of_row.size() : 0;
  WriteMap(map, file, {.overwrite = true});
  json["file_bytes"] = fs::file_size(file);
  const nlohmann::json opened = OpenElsewhere(file);
  json["open_s"] = opened["open_s"];
  const double descriptor_bytes = 128.0 * static_cast<double>(CountFeatures(map));
  json["memory_ratio"] = opened["bytes"].get<double>() / descriptor_bytes;
  const auto index = MapIndex::Build(std::move(map));
  AskAll(scene, *index);  // to warm up the caches
  const Timed timed = AskAll(scene, *index);
  json["queries"] = timed.answers.size();
  json["localized"] = timed.localized;
  json["right"] = timed.right;
  json["median_ms"] = {{"floor", Quantile(timed.floor_ms, 0.5)},
                       {"shortlist", Quantile(timed.shortlist_ms, 0.5)},
                       {"verify", Quantile(timed.verify_ms, 0.5)},
                       {"total", Quantile(timed.total_ms, 0.5)}};
  json["ratio"] = Quantile(timed.ratio, 0.5);
  const double floor_ms = Quantile(timed.floor_ms, 0.5);
  json["shortlist_over_floor"] = Quantile(timed.shortlist_ms, 0.5) / floor_ms;
  json["verify_over_floor"] = Quantile(timed.verify_ms, 0.5) / floor_ms;
  const Comparison comparison = Compare(scene, *index, timed);
  json["exhaustive"] = {
      {"shortlist_ms", comparison.exhaustive_ms},
      {"localized", comparison.localized},
      {"found", comparison.found},
      {"nearest_share", static_cast<double>(comparison.nearest) / comparison.features},
      {"distinct_nearest_share", static_cast<double>(comparison.distinct_nearest) /
                                     std::max<int64_t>(1, comparison.distinct)}};
  return json;
}

void PrintHeading() {
  std::printf("%9s %6s %8s %8s %8s %8s %6s %6s %6s %7s %7s %7s %6s %6s %9s\n", "features", "lists",
              "floor", "short.", "verify", "total", "ratio", "right", "found", "nearest",
              "distinct", "exhaust", "open", "memory", "index");
}

void PrintRow(const nlohmann::ordered_json& j) {
  const auto& ms = j["median_ms"];
  const auto& e = j["exhaustive"];
  std::printf(
      "%9lld %6d %5.1f ms %5.1f ms %5.1f ms %5.1f ms %6.2f %3d/%-3d %3d/%-3d %6.2f%% %6.2f%% "
      "%4.0f ms %4.2f s %6.2f %6.0f KB\n",
      j["features"].get<long long>(), j["lists"].get<int>(), ms["floor"].get<double>(),
      ms["shortlist"].get<double>(), ms["verify"].get<double>(), ms["total"].get<double>(),
      j["ratio"].get<double>(), j["right"].get<int>(), j["queries"].get<int>(),
      e["found"].get<int>(), e["localized"].get<int>(), 100 * e["nearest_share"].get<double>(),
      100 * e["distinct_nearest_share"].get<double>(), e["shortlist_ms"].get<double>(),
      j["open_s"].get<double>(), j["memory_ratio"].get<double>(),
      j["index_bytes"].get<double>() / 1000);
  (void)std::fflush(stdout);
}

}  // namespace

int RunScale(const Args& raw) {
  Args args = raw;
  if (const std::string map = TakeOption(args, "open", ""); !map.empty()) return OpenOnly(map);
  if (args.empty()) args = {"100000", "1000000"};
  cv::setNumThreads(1);
  const MappedWorld scene;
  const ScratchFolder scratch;
  const fs::path file = scratch.path() / "map.db";
  nlohmann::ordered_json json = {{"bench", "scale"}, {"runs", nlohmann::ordered_json::array()}};
  PrintHeading();
  for (const std::string& features : args) {
    json["runs"].push_back(Measure(scene, std::stoll(features), file));
    PrintRow(json["runs"].back());
  }
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
