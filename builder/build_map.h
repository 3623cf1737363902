// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "builder/appearance/build_appearance.h"
#include "builder/calibration/appearance_calibration.h"
#include "builder/calibration/calibrate.h"
#include "builder/layer_choice.h"
#include "builder/orientation/orientation_layer.h"
#include "builder/planes/keyframe_selector.h"
#include "builder/planes/options.h"
#include "builder/sources/source.h"
#include "core/base/option_members.h"
#include "core/features/features.h"
#include "schema/map_data.h"

namespace waystone {

struct BuildOptions {
  std::string map_name = "map";
  FeatureOptions features;
  KeyframeOptions keyframes;
  PlaneLayerOptions planes;
  AppearanceOptions appearance;
  OrientationOptions orientation;
  LayerChoice layers;
  CalibrationOptions calibration;
  AppearanceCalibrationOptions appearance_calibration;
  bool images = true;
  int image_width = 320;
  // Threads for reading and features; 0 takes as many as there are cores. The map doesn't depend
  // on it.
  int threads = 0;

  // A map has its name in another place and doesn't depend on the threads.
  static constexpr int kUnlistedMembers = 2;
  static constexpr auto Fields() {
    return std::tuple_cat(
        ListedGroup("features", &BuildOptions::features),
        ListedGroup("keyframes", &BuildOptions::keyframes),
        ListedGroup("planes", &BuildOptions::planes),
        ListedGroup("appearance", &BuildOptions::appearance),
        ListedGroup("orientation", &BuildOptions::orientation),
        ListedGroup("layers", &BuildOptions::layers),
        ListedGroup("calibration", &BuildOptions::calibration),
        ListedGroup("appearance_calibration", &BuildOptions::appearance_calibration),
        std::tuple{OptionField{"images", &BuildOptions::images, AnyValue(), "",
                               "Keep a smaller JPEG of each keyframe and node in the map, for "
                               "people."},
                   OptionField{"image_width", &BuildOptions::image_width, Closed(16, 4096), "px",
                               "Width of those JPEGs. Larger ones show more and take most of a "
                               "map's bytes."}});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// How far a build is; handed to the progress callback, one call at a time but from any thread.
struct BuildProgress {
  // "frames", "fusion"; "panoramas", "odometry", "loops", "poses", "calibration"; "directions"
  std::string stage;
  int done = 0;
  int total = 0;  // 0 when not known
  int keyframes = 0;
  int planes = 0;
  int panoramas = 0;  // read so far
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
  double total_s = 0;                          // wall clock
  std::optional<AppearanceReport> appearance;  // where that layer was built
  std::optional<OrientationReport> orientation;
};

struct BuildResult {
  MapData map;
  BuildReport report;
};

// The layers of a map over one or several sequences: Algorithm 1 of the paper for the planes, which
// reads like it, BuildAppearanceLayer for panoramas, and the orientation layer of calibrated
// sources, whose images are decoded once for both. `progress` may be empty;
// when it returns false, the build stops with MapError(kInterrupted).
// Throws MapError(kBadSource) when no source has a usable frame, or none fits a layer chosen;
// kBadCamera when the orientation layer is chosen and no source is calibrated.
BuildResult BuildMap(const std::vector<std::unique_ptr<Source>>& sources,
                     const BuildOptions& options,
                     const std::function<bool(const BuildProgress&)>& progress);

}  // namespace waystone
