// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "builder/appearance/appearance_layer.h"
#include "builder/poses/options.h"
#include "schema/map_data.h"

namespace waystone {

// What became of the poses that were given for panoramas.
struct NodePoseReport {
  int nodes = 0;  // panoramas of the map
  int posed = 0;  // of them, have a pose
  std::string first_without;
  // Share of the motions between panoramas that agree; nothing where too few could be compared.
  std::optional<double> consistent;
  // Answers about panoramas of the map, each without itself, that their errors were measured on.
  int measured_by_appearance = 0;
  int measured_by_features = 0;
};

// Puts a finished appearance layer into the frame of the given poses, beside the keyframes that are
// in it: nodes and samples are where their poses are as seen from above (Horizontal), in metres
// where those are; measured motions are scaled. Nodes without a pose keep their place between those
// around them in their sequence by what the layer said, and get none. Where no panorama but
// keyframes have poses, the layer stays as it is. Deterministic on any number of threads.
// Throws MapError(kBadRequest) where too few panoramas have a pose, or their poses contradict what
// the panoramas show of each other, saying how they would fit.
NodePoseReport AddNodePoses(const GivenPoses& poses, const PoseOptions& options, MapData& map,
                            std::vector<AppearanceSampleFrame>& samples);

}  // namespace waystone
