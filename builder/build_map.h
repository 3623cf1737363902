// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "builder/calibrate.h"
#include "builder/keyframes/keyframe_selector.h"
#include "builder/planes/options.h"
#include "builder/sources/source.h"
#include "core/features/features.h"
#include "schema/map_data.h"

namespace waystone {

struct BuildOptions {
  std::string map_name = "map";
  FeatureOptions features;
  KeyframeOptions keyframes;
  PlaneLayerOptions planes;
  CalibrationOptions calibration;
  // Keep a smaller JPEG of each keyframe in the map, for people.
  bool images = true;
  int image_width = 320;  // px
  // Threads for reading and features; 0 takes as many as there are cores. The map doesn't depend
  // on it.
  int threads = 0;

  void Check() const;  // throws MapError(kBadOptions)
};

// How far a build is; handed to the progress callback, one call at a time but from any thread.
struct BuildProgress {
  std::string stage;  // "frames", "fusion"
  int done = 0;
  int total = 0;  // 0 when not known
  int keyframes = 0;
  int planes = 0;
};

// What a build did: for the report and the benches.
struct BuildReport {
  int frames = 0;
  int skipped = 0;                         // frames that could not be decoded
  std::vector<std::string> skipped_names;  // "rgb/000120.jpg: cause", the first 20 of them
  int stretches = 0;
  int rotation_only = 0;  // keyframe pairs that only rotated
  int planes_started = 0;
  int planes_rejected = 0;   // by the homology test
  int planes_merged = 0;     // by the homology test (identity) while tracking
  int planes_fused = 0;      // by eq. (6)
  int planes_dropped = 0;    // too few features left after the votes
  int features_dropped = 0;  // by the votes
  double decode_s = 0;       // summed over threads
  double extract_s = 0;      // summed over threads
  double track_s = 0;        // keyframe choice and planes
  double choose_s = 0;       // of it, keyframe choice
  double fusion_s = 0;
  double calibrate_s = 0;
  double total_s = 0;  // wall clock
};

struct BuildResult {
  MapData map;
  BuildReport report;
};

// Algorithm 1 of the paper over one or several sequences: reads like it. `progress` may be empty;
// when it returns false, the build stops with MapError(kInterrupted).
// Throws MapError(kBadSource) when no source has a usable frame.
BuildResult BuildMap(const std::vector<std::unique_ptr<Source>>& sources,
                     const BuildOptions& options,
                     const std::function<bool(const BuildProgress&)>& progress);

}  // namespace waystone
