// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include "schema/layers/appearance/appearance_layer.h"
#include "schema/layers/poses/pose_layer.h"

namespace waystone {

// Nodes that are this many spacings apart in height may be on different floors.
inline constexpr double kSameFloorSpacings = 2;

// Distances between the nodes of an appearance layer, by their indices: in space where both have a
// pose, since floors lie above each other, and else as seen from above. Immutable; any number of
// threads may share it.
class NodeDistances {
 public:
  NodeDistances() = default;
  // The layer is in the frame of `poses` where these have nodes; null where the map has none.
  explicit NodeDistances(const AppearanceLayer& layer, const PoseLayer* poses = nullptr);

  double Squared(int a, int b) const {
    const double x = nodes_[a].x - nodes_[b].x;
    const double y = nodes_[a].y - nodes_[b].y;
    const double height = Height(a, b);
    return x * x + y * y + height * height;
  }
  double Between(int a, int b) const {
    return std::hypot(std::hypot(nodes_[a].x - nodes_[b].x, nodes_[a].y - nodes_[b].y),
                      Height(a, b));
  }
  // The height of each node; NaN where it has no pose.
  std::vector<double> Heights() const {
    std::vector<double> heights;
    for (const Place& node : nodes_) heights.push_back(node.height);
    return heights;
  }
  // The difference in height; 0 where one of them has no pose.
  double Height(int a, int b) const {
    const double height = std::abs(nodes_[a].height - nodes_[b].height);
    return std::isnan(height) ? 0 : height;
  }

 private:
  struct Place {
    double x = 0;
    double y = 0;
    double height = std::numeric_limits<double>::quiet_NaN();  // not known
  };

  std::vector<Place> nodes_;
};

}  // namespace waystone
