// SPDX-License-Identifier: Apache-2.0
#include "bench/baseline/make_graphs.h"

#include <algorithm>

#include "bench/accuracy/common.h"
#include "bench/accuracy/feature_layer.h"
#include "bench/accuracy/stopwatch.h"
#include "bench/baseline/image_store.h"
#include "builder/frames/frame_pipeline.h"
#include "core/base/check.h"
#include "schema/file/map_store.h"
#include "schema/layers/planes/index_features.h"

namespace waystone::bench {
namespace {

namespace fs = std::filesystem;

Cost operator+(const Cost& a, const Cost& b) { return {a.wall_s + b.wall_s, a.cpu_s + b.cpu_s}; }
Cost operator-(const Cost& a, const Cost& b) { return {a.wall_s - b.wall_s, a.cpu_s - b.cpu_s}; }

template <class F>
Cost Timed(F work) {
  const Stopwatch watch;
  work();
  return {watch.wall_s(), watch.cpu_s()};
}

// What both graphs are made from.
struct Shared {
  std::vector<ChosenKeyframe> keyframes;
  Cost cost;
};

Shared TakeKeyframes(const Scene& scene, const BuildOptions& options) {
  Shared shared;
  shared.cost = Timed([&] {
    const auto source = scene.OpenMap();
    KeyframeSelector selector(options.keyframes, options.planes.match);
    const auto keep = [&](std::vector<ChosenKeyframe> chosen) {
      std::move(chosen.begin(), chosen.end(), std::back_inserter(shared.keyframes));
    };
    FeatureLayer layer(options.features,
                       [&](ExtractedFrame frame) { keep(selector.Add(std::move(frame))); });
    BuildLayer({source.get()}, layer);
    keep(selector.Finish());
  });
  return shared;
}

std::vector<ImageNode> NodesOf(const Shared& shared, const MapData& map) {
  WS_CHECK(shared.keyframes.size() == map.keyframes.size(), "the graphs have other keyframes");
  std::vector<ImageNode> nodes;
  for (size_t i = 0; i < shared.keyframes.size(); ++i) {
    const ExtractedFrame& frame = shared.keyframes[i].frame;
    WS_CHECK(frame.info.number == map.keyframes[i].frame, "the graphs have other keyframes");
    nodes.push_back({map.keyframes[i].id, frame.info.number, frame.features});
  }
  return nodes;
}

MapData MakePlaneGraph(const Scene& scene, BuildOptions options, const fs::path& folder,
                       Graphs& graphs) {
  options.images = false;
  const fs::path path = folder / "planes.db";
  MapData map;
  graphs.planes.whole = Timed([&] {
    std::vector<std::unique_ptr<Source>> sources;
    sources.push_back(scene.OpenMap());
    BuildResult built = BuildMap(sources, options, {});
    WriteMap(built.map, path, {});
    graphs.calibrate_s = built.report.planes->calibrate_s;
    map = std::move(built.map);
  });
  graphs.planes.own = graphs.planes.whole - graphs.shared;
  graphs.planes.nodes = map.planes.size();
  graphs.planes.edges = map.edges.size();
  graphs.planes.features = CountFeatures(map);
  graphs.planes.bytes = fs::file_size(path);
  graphs.index = MapIndex::Build(ReadMap(path));
  return map;
}

void MakeImageGraph(std::vector<ImageNode> nodes, const fs::path& folder, Graphs& graphs) {
  const fs::path path = folder / "images.db";
  graphs.images.own = Timed(
      [&] { WriteImageGraph(BuildImageGraph(std::move(nodes), graphs.image_options), path); });
  graphs.images.whole = graphs.shared + graphs.images.own;
  graphs.image_graph = ReadImageGraph(path);
  graphs.images.nodes = graphs.image_graph.nodes.size();
  graphs.images.edges = graphs.image_graph.edges.size();
  for (const ImageNode& node : graphs.image_graph.nodes) {
    graphs.images.features += node.features.size();
  }
  graphs.images.bytes = fs::file_size(path);
}

}  // namespace

Graphs MakeGraphs(const Scene& scene, const BuildOptions& options, const fs::path& folder) {
  Graphs graphs;
  const Shared shared = TakeKeyframes(scene, options);
  graphs.shared = shared.cost;
  const MapData map = MakePlaneGraph(scene, options, folder, graphs);
  graphs.image_options.match = options.planes.match;
  MakeImageGraph(NodesOf(shared, map), folder, graphs);
  return graphs;
}

}  // namespace waystone::bench
