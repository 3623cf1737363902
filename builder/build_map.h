// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "builder/appearance/appearance_layer.h"
#include "builder/build_options.h"
#include "builder/frames/progress.h"
#include "builder/orientation/orientation_layer.h"
#include "builder/planes/plane_layer.h"
#include "builder/poses/add_node_poses.h"
#include "builder/poses/add_poses.h"
#include "builder/sources/source.h"
#include "schema/map_data.h"

namespace waystone {

// What a build did: for the report and the benches. A layer that wasn't built has none.
struct BuildReport {
  std::optional<PlaneReport> planes;
  std::optional<AppearanceReport> appearance;
  std::optional<OrientationReport> orientation;
  std::optional<PoseReport> poses;           // of keyframes
  std::optional<NodePoseReport> node_poses;  // of panoramas
  double total_s = 0;                        // wall clock
};

struct BuildResult {
  MapData map;
  BuildReport report;
  std::vector<WalkImage> features;  // of the images, with BuiltFeatures::kKeep
};

// Whether a build returns the features of all keyframes, and of some images between them.
enum class BuiltFeatures { kDrop, kKeep };

// The layers of a map over one or several sequences. Each source is read once, by all of its layers
// (ChooseLayers); sequences of planes come first in the map, then those of panoramas, then those of
// only the orientation layer. Runs on options.threads of TBB's threads, turns OpenCV's own threads
// off for the whole process, and calls ThrowOpenCvErrors. When `progress` returns false, the build
// stops with MapError(kInterrupted).
// Throws MapError(kBadSource) when a source has no usable frame, or none fits a layer chosen;
// kUnreadableFrames when too few are usable (max_skipped_share); kBadCamera when the orientation
// layer is chosen and no source is calibrated; kBadOptions. With `poses` the plane and the
// appearance layer are put into their frame; at least one of the two must be built, and the plane
// layer's cameras must be calibrated. Also throws what AddPoses and AddNodePoses throw.
BuildResult BuildMap(const std::vector<std::unique_ptr<Source>>& sources,
                     const BuildOptions& options, const ProgressCallback& progress,
                     const std::optional<GivenPoses>& poses = std::nullopt,
                     BuiltFeatures features = BuiltFeatures::kDrop);

}  // namespace waystone
