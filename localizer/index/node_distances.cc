// SPDX-License-Identifier: Apache-2.0
#include "localizer/index/node_distances.h"

#include "schema/layers/poses/horizontal.h"

namespace waystone {

NodeDistances::NodeDistances(const AppearanceLayer& layer, const PoseLayer* poses) {
  for (const AppearanceNode& node : layer.nodes) nodes_.push_back({node.pose.x, node.pose.y});
  if (poses == nullptr || poses->nodes.empty()) return;
  const Eigen::Vector3d up = HorizontalOf(*poses).up;
  for (size_t i = 0; i < nodes_.size(); ++i) {
    const NodePose* pose = poses->Find(layer.nodes[i].id);
    if (pose) nodes_[i].height = up.dot(pose->position);
  }
}

}  // namespace waystone
