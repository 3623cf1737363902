// SPDX-License-Identifier: Apache-2.0
// The paper's tables I, II and III for an image graph and the plane graph over the same keyframes.
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>

#include "bench/accuracy/common.h"
#include "bench/accuracy/stopwatch.h"
#include "bench/baseline/make_graphs.h"
#include "bench/baseline/scenes.h"
#include "core/base/error.h"
#include "localizer/planes/locate.h"

namespace waystone::bench {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// A row of the paper's table III.
struct QueryFigures {
  std::vector<double> own_ms;    // from the query's features to the answer
  std::vector<double> whole_ms;  // from the encoded image
  int answered = 0;
  int right = 0;
  int ambiguous = 0;  // not answered, several places look alike
};

// "M:N", of KeyframeOptions.
BuildOptions KeyframesAsTold(const std::string& text) {
  BuildOptions options;
  const std::vector<int> counts = ParseNumbers(text, ':');
  if (counts.size() != 2) {
    throw MapError(ErrorCode::kUsage, "'" + text + "' is no M:N; write --keyframes 300:150");
  }
  options.keyframes.min_matches_last = counts[0];
  options.keyframes.min_matches_before_last = counts[1];
  return options;
}

SceneAnswer AnswerOf(const Graphs& graphs, const Features& query, const ImageAnswer& answer) {
  const ImageNode& node = graphs.image_graph.nodes[answer.node];
  return {node.frame, node.frame, MoveAll(ImageFromWorking(query), answer.query_points),
          MoveAll(answer.node_from_query, answer.query_points), node.features.width};
}

struct Table3 {
  QueryFigures planes;
  QueryFigures best_place;  // planes, too, but the best place wins however close the second one is
  QueryFigures images;
  QueryFigures opencv;            // of every n-th query
  QueryFigures planes_as_opencv;  // of the same ones
};

// CPU milliseconds of this process: queries run on one thread, and other programs don't count.
template <class F>
double Ms(F work) {
  const Stopwatch watch;
  work();
  return 1000 * watch.cpu_s();
}

void Count(const Scene& scene, int query, const std::optional<SceneAnswer>& answer, double own_ms,
           double shared_ms, QueryFigures& figures) {
  figures.own_ms.push_back(own_ms);
  figures.whole_ms.push_back(shared_ms + own_ms);
  if (!answer) return;
  ++figures.answered;
  figures.right += scene.IsRight(query, *answer);
}

// Puts every query to each graph in turn, on one core.
Table3 Ask(const Scene& scene, const Graphs& graphs, int opencv_every) {
  Table3 table;
  std::vector<cv::Mat> floats;
  for (const ImageNode& node : graphs.image_graph.nodes) {
    floats.push_back(FloatDescriptors(node.features));
  }
  LocalizeOptions options;
  options.planes = graphs.image_options.localize;
  // Images have no verdict "ambiguous": this is the planes' answer to the same question.
  LocalizeOptions best_place = options;
  best_place.planes.gates.ambiguous_share = 1;
  for (int q = 0; q < scene.queries(); ++q) {
    Features features;
    const double shared_ms = Ms([&] {
      features =
          ExtractFeatures(scene.Decode(q), QueryFeatureOptions(*graphs.index, options.planes));
    });
    const auto ask_planes = [&](const LocalizeOptions& with, QueryFigures& figures) {
      Answer by_planes;
      const double ms = Ms([&] { by_planes = LocalizeFeatures(*graphs.index, features, with); });
      ToImagePixels(features, by_planes.planes);
      std::optional<SceneAnswer> answer;
      if (by_planes.verdict == Verdict::kLocalized)
        answer = SceneAnswerOf(*graphs.index, by_planes);
      figures.ambiguous += by_planes.verdict == Verdict::kAmbiguous;
      Count(scene, q, answer, ms, shared_ms, figures);
    };
    const bool of_opencv = opencv_every > 0 && q % opencv_every == 0;
    ask_planes(options, table.planes);
    ask_planes(best_place, table.best_place);
    if (of_opencv) ask_planes(options, table.planes_as_opencv);

    ImageAnswer by_images;
    const auto found = [&]() -> std::optional<SceneAnswer> {
      if (by_images.node < 0) return std::nullopt;
      return AnswerOf(graphs, features, by_images);
    };
    const double images_ms = Ms(
        [&] { by_images = LocalizeInImages(graphs.image_graph, features, graphs.image_options); });
    Count(scene, q, found(), images_ms, shared_ms, table.images);
    if (!of_opencv) continue;
    const double opencv_ms = Ms([&] {
      by_images = LocalizeWithOpenCv(graphs.image_graph, floats, features, graphs.image_options);
    });
    Count(scene, q, found(), opencv_ms, shared_ms, table.opencv);
  }
  return table;
}

double Mean(const std::vector<double>& values) {
  double sum = 0;
  for (double value : values) sum += value;
  return values.empty() ? 0 : sum / static_cast<double>(values.size());
}

void PrintGraph(const char* name, const GraphFigures& g) {
  std::printf("%-12s %6zu %6zu %9lld %10.0f %8.2f %9.2f %7.2f %8.1f %7.1f\n", name, g.nodes,
              g.edges, static_cast<long long>(g.features),
              static_cast<double>(g.features) / static_cast<double>(std::max<size_t>(1, g.nodes)),
              static_cast<double>(g.bytes) / 1e6, g.own.wall_s, g.own.cpu_s, g.whole.wall_s,
              g.whole.cpu_s);
}

void PrintQueries(const char* name, const QueryFigures& q) {
  if (q.own_ms.empty()) return;
  std::printf("%-12s %7.1f %7.1f %11.1f %11.1f %8zu %9d %6d %6d %10d\n", name, Mean(q.own_ms),
              Quantile(q.own_ms, 0.5), Mean(q.whole_ms), Quantile(q.whole_ms, 0.5), q.own_ms.size(),
              q.answered, q.right, q.answered - q.right, q.ambiguous);
}

Json ToJson(const QueryFigures& q) {
  return {{"localize_ms", Mean(q.own_ms)},
          {"localize_median_ms", Quantile(q.own_ms, 0.5)},
          {"localize_whole_ms", Mean(q.whole_ms)},
          {"queries", q.own_ms.size()},
          {"answered", q.answered},
          {"right", q.right},
          {"wrong", q.answered - q.right},
          {"ambiguous", q.ambiguous},
          {"not_found", static_cast<int>(q.own_ms.size()) - q.answered - q.ambiguous}};
}

Json ToJson(const GraphFigures& g) {
  return {{"nodes", g.nodes},
          {"edges", g.edges},
          {"features", g.features},
          {"bytes", g.bytes},
          {"own_s", g.own.wall_s},
          {"own_cpu_s", g.own.cpu_s},
          {"whole_s", g.whole.wall_s},
          {"whole_cpu_s", g.whole.cpu_s},
          {"features_per_node",
           static_cast<double>(g.features) / static_cast<double>(std::max<size_t>(1, g.nodes))}};
}

double Ratio(double images, double planes) { return planes > 0 ? images / planes : 0; }

Json RatiosOf(const Graphs& g, const Table3& t) {
  return {
      {"file", Ratio(static_cast<double>(g.images.bytes), static_cast<double>(g.planes.bytes))},
      {"build_own", Ratio(g.images.own.wall_s, g.planes.own.wall_s)},
      {"build_own_cpu", Ratio(g.images.own.cpu_s, g.planes.own.cpu_s)},
      {"build_whole", Ratio(g.images.whole.wall_s, g.planes.whole.wall_s)},
      {"build_whole_cpu", Ratio(g.images.whole.cpu_s, g.planes.whole.cpu_s)},
      {"localize_own", Ratio(Mean(t.images.own_ms), Mean(t.planes.own_ms))},
      {"localize_whole", Ratio(Mean(t.images.whole_ms), Mean(t.planes.whole_ms))},
      {"localize_own_opencv", Ratio(Mean(t.opencv.own_ms), Mean(t.planes_as_opencv.own_ms))},
      {"localize_whole_opencv", Ratio(Mean(t.opencv.whole_ms), Mean(t.planes_as_opencv.whole_ms))}};
}

Json Report(const Scene& scene, const Graphs& g, const Table3& t) {
  std::printf("\n%s: %zu keyframes\n", scene.name().c_str(), g.images.nodes);
  std::printf(
      "tables I, II  nodes  edges  features feats/node       MB  build: own s  (cpu)  whole s   "
      "(cpu)\n");
  PrintGraph("image graph", g.images);
  PrintGraph("plane graph", g.planes);
  std::printf("shared by both: %.1f s (%.1f s on the cores); calibration of the planes: %.1f s\n",
              g.shared.wall_s, g.shared.cpu_s, g.calibrate_s);
  std::printf(
      "table III     own ms  median    whole ms      median  queries  answered  right  "
      "wrong  ambiguous\n");
  PrintQueries("image graph", t.images);
  PrintQueries("plane graph", t.planes);
  PrintQueries("  best place", t.best_place);
  PrintQueries("cv::BFMatcher", t.opencv);
  std::printf("right: %s\n", scene.Criterion().c_str());
  const Json ratios = RatiosOf(g, t);
  std::printf("image graph / plane graph:");
  for (const auto& [name, ratio] : ratios.items()) {
    std::printf(" %s %.1f", name.c_str(), ratio.get<double>());
  }
  std::printf("\n");
  (void)std::fflush(stdout);
  return {{"scene", scene.name()},
          {"keyframes", g.images.nodes},
          {"kept_one_in", static_cast<double>(g.images.features) /
                              static_cast<double>(std::max<int64_t>(1, g.planes.features))},
          {"shared_s", g.shared.wall_s},
          {"shared_cpu_s", g.shared.cpu_s},
          {"calibrate_s", g.calibrate_s},
          {"images", ToJson(g.images)},
          {"planes", ToJson(g.planes)},
          {"queries",
           {{"images", ToJson(t.images)},
            {"planes", ToJson(t.planes)},
            {"best_place", ToJson(t.best_place)},
            {"opencv", ToJson(t.opencv)}}},
          {"ratios", ratios}};
}

bool IsRgbd(const std::string& source) { return fs::exists(fs::path(source) / "rgb.txt"); }

std::unique_ptr<Scene> OpenScene(const std::string& source, const Range& map,
                                 const Range& queries) {
  constexpr int kWorldFrames = 400;
  constexpr int kWorldQueries = 50;
  if (source == "world") return MakeWorldScene(kWorldFrames, kWorldQueries, {});
  if (IsRgbd(source)) return OpenRgbdScene(source, map, queries, {});
  if (fs::exists(fs::path(source) / "poses.csv")) return OpenPhotoScene(source, {});
  throw MapError(ErrorCode::kUsage, source +
                                        " is neither 'world' nor a TUM RGB-D folder nor one with "
                                        "map/, query*/ and poses.csv");
}

}  // namespace

int RunGraphs(const Args& raw) {
  Args args = raw;
  const Range map = ParseRange(TakeOption(args, "map", "0:499"));
  const Range queries = ParseRange(TakeOption(args, "queries", "500:990:10"));
  // Half above the product's 300:150: the comparison should have at least 100 keyframes.
  const BuildOptions dense = KeyframesAsTold(TakeOption(args, "keyframes", "450:225"));
  const int opencv_every = std::stoi(TakeOption(args, "opencv-every", "10"));
  if (args.empty()) args = {"world"};
  cv::setNumThreads(1);
  Json json = {{"bench", "graphs"}, {"scenes", Json::array()}};
  tbb::task_arena arena;
  for (const std::string& source : args) {
    const ScratchFolder scratch;
    const auto scene = OpenScene(source, map, queries);
    const BuildOptions options = IsRgbd(source) ? dense : BuildOptions{};
    arena.execute([&] {
      const Graphs graphs = MakeGraphs(*scene, options, scratch.path());
      json["scenes"].push_back(Report(*scene, graphs, Ask(*scene, graphs, opencv_every)));
    });
  }
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
