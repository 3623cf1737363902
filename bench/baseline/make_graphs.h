// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "bench/baseline/image_graph.h"
#include "bench/baseline/scenes.h"
#include "builder/build_map.h"
#include "localizer/index/map_index.h"

namespace waystone::bench {

// Seconds on the clock, and summed over all cores.
struct Cost {
  double wall_s = 0;
  double cpu_s = 0;
};

// A row of the paper's table I.
struct GraphFigures {
  size_t nodes = 0;
  size_t edges = 0;
  int64_t features = 0;
  uintmax_t bytes = 0;
  Cost own;    // of the whole, without what both graphs share
  Cost whole;  // from images to the file
};

// Both graphs of a scene, as read back from their files, which have no pictures.
struct Graphs {
  GraphFigures planes;
  GraphFigures images;
  Cost shared;             // decoding, features and keyframe choice, on all cores
  double calibrate_s = 0;  // of the planes' own: search index, revisits and the verdict's model
  std::shared_ptr<const MapIndex> index;
  ImageGraph image_graph;
  ImageGraphOptions image_options;
};

// Builds both graphs over the same keyframes on the threads of the calling arena, measures both and
// writes them into `folder`, which must be empty.
Graphs MakeGraphs(const Scene& scene, const BuildOptions& options,
                  const std::filesystem::path& folder);

}  // namespace waystone::bench
