// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "builder/poses/options.h"
#include "schema/map_data.h"

namespace waystone {

// The poses of a map's nodes, in their order.
using GivenNodePoses = std::vector<std::optional<Eigen::Isometry3d>>;

// How the camera moved and turned between panoramas of a map: by their features where they keep
// some, else by the compass. Immutable after construction.
class PanoramaMotions {
 public:
  // Between nodes with poses. The map has an appearance layer (WS_CHECK). Deterministic on any
  // number of threads.
  PanoramaMotions(const MapData& map, const GivenNodePoses& poses, const PoseOptions& options);

  // The share of the motions that agree with these poses, or that of the motions with a turn where
  // it is smaller. Nothing where there are too few. `poses` are of the same nodes as the
  // constructor's.
  std::optional<double> ConsistentShare(const GivenNodePoses& poses) const;

 private:
  struct Seen {
    int a = 0;  // indices of nodes
    int b = 0;
    Eigen::Matrix3d b_from_a = Eigen::Matrix3d::Identity();
    std::optional<Eigen::Vector3d> direction;  // unit: x_b = b_from_a x_a + s * direction
  };
  struct Turned {
    int a = 0;
    int b = 0;
    double turn_rad = 0;  // of b against a, counter-clockwise from above
    double sigma_rad = 0;
  };

  void MatchFeatures(const MapData& map, const GivenNodePoses& poses);
  void TakeTurns(const MapData& map, const GivenNodePoses& poses);
  std::optional<double> ShareOfSeen(const GivenNodePoses& poses) const;
  std::optional<double> ShareOfTurned(const GivenNodePoses& poses) const;

  const PoseOptions& options_;
  std::vector<Seen> seen_;
  std::vector<Turned> turned_;
};

}  // namespace waystone
