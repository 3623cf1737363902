// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "builder/planes/keyframe_sample.h"
#include "builder/poses/options.h"
#include "schema/map_data.h"

namespace waystone {

// How consistent the poses are (builder/calibration/pose_calibration).
struct PoseNoiseReport {
  static constexpr int kFewest = 8;  // keyframes to measure it with

  PoseNoise noise;
  int asked = 0;     // keyframes
  int measured = 0;  // of them, could be localized by the others
};

// How the given poses were used.
struct PoseReport {
  int keyframes = 0;      // of the map
  int posed = 0;          // of them, have a pose
  int planes = 0;         // that were fitted
  int features = 0;       // of planes and landmarks of posed keyframes
  int placed = 0;         // of them, have a depth
  int contradicting = 0;  // whose sightings contradict the poses
  double consistent = 0;  // share of the matches of neighbouring keyframes that agree
  PoseNoiseReport noise;
  double seconds = 0;
};

// Puts a finished plane layer into the frame of the given poses, which are kept fixed: estimates
// the distance of each plane feature and landmark from its keyframe by its sightings in other
// keyframes (core/camera_pose/inverse_depth), fits planes to their features, and combines both;
// features that contradict the poses get no depth. `features` are those of all keyframes.
// Deterministic on any number of threads.
// Throws MapError: kBadCamera for a sequence without a calibration; kBadRequest where too few
// keyframes have a pose or the poses contradict the images, saying whether they would fit as
// camera-from-world transforms or with other axes.
PoseReport AddPoses(const std::vector<SampledKeyframe>& features, const GivenPoses& poses,
                    const PoseOptions& options, MapData& map);

}  // namespace waystone
