// SPDX-License-Identifier: Apache-2.0
#include "core/manhattan/directed_segments.h"

#include "core/base/check.h"
#include "core/manhattan/line_model.h"

namespace waystone {
namespace {

// Building axes of a rig that stands upright and looks along x.
Eigen::Matrix3d UprightRig() {
  Eigen::Matrix3d rig_from_building;
  rig_from_building << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return rig_from_building;
}

}  // namespace

DirectedSegments FindDirectedSegments(const cv::Mat& grey, const Camera& camera,
                                      const std::optional<Eigen::Matrix3d>& rig_from_building,
                                      const SegmentOptions& segments,
                                      const ManhattanOptions& manhattan) {
  WS_CHECK(camera.model != CameraModel::kEquirectangular, "lines of a panorama are bent");
  const std::vector<GreatCircle> circles =
      FindGreatCircles(RigOfOne(camera), 0, DetectSegments(grey, segments));
  DirectedSegments found;
  Eigen::Matrix3d axes;
  if (rig_from_building) {
    axes = *rig_from_building;
    found.reliable = true;
  } else {
    const ManhattanFrame frame = Renumbered(FindManhattanFrame(circles, manhattan), UprightRig());
    axes = frame.rig_from_axes;
    found.reliable = frame.reliable();
  }
  for (const Line& line : SelectLines(circles, manhattan.max_lines)) {
    found.segments.push_back(
        {circles[line.index].segment, ComputeSupport(line, axes, manhattan).axis});
  }
  return found;
}

}  // namespace waystone
