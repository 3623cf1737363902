// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "builder/appearance/appearance_layer.h"
#include "builder/poses/options.h"
#include "schema/map_data.h"

namespace waystone {

// How the given poses of panoramas were used.
struct NodePoseReport {
  int nodes = 0;  // panoramas of the map
  int posed = 0;  // of them, have a pose
  std::string first_without;
  // Share of the motions between panoramas that agree; nothing where too few could be compared.
  std::optional<double> consistent;
  // Answers about panoramas of the map, each without its own node, from which the errors were
  // measured.
  int measured_by_appearance = 0;
  int measured_by_features = 0;
};

// Puts a finished appearance layer into the frame of the given poses, along with the keyframes:
// nodes and samples are moved to their poses as seen from above (Horizontal), in metres where those
// are; measured motions are scaled. Nodes without a pose are interpolated between their neighbours
// in the sequence by the layer's own motions, and get no pose. Where only keyframes have poses, the
// layer stays as it is. Deterministic on any number of threads.
// Throws MapError(kBadRequest) where too few panoramas have a pose, or their poses contradict what
// the panoramas show of each other, saying how they would fit.
NodePoseReport AddNodePoses(const GivenPoses& poses, const PoseOptions& options, MapData& map,
                            std::vector<AppearanceSampleFrame>& samples);

}  // namespace waystone
