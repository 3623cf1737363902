// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "core/camera/camera.h"
#include "core/manhattan/manhattan_frame.h"
#include "core/manhattan/segments.h"

namespace waystone {

// A straight line of a picture and the building's axis along which it runs.
struct DirectedSegment {
  ImageSegment segment;  // px of the picture
  int axis = -1;         // 0 x, 1 y, 2 z, or -1 for none
};

struct DirectedSegments {
  std::vector<DirectedSegment> segments;
  // Whether the axes can be relied on: always true for given axes.
  bool reliable = false;
};

// The straight lines of a picture (CV_8UC1, of the camera's size) with their axes of the building,
// the longest ones (sec. II-A and fig. 2 of Puig et al. 2012). Without rig_from_building the lines
// themselves give the axes: z is the one nearest to the picture's upright, x the one nearest to the
// view ahead. Any camera but an equirectangular one. Deterministic; thread-safe.
DirectedSegments FindDirectedSegments(const cv::Mat& grey, const Camera& camera,
                                      const std::optional<Eigen::Matrix3d>& rig_from_building,
                                      const SegmentOptions& segments = {},
                                      const ManhattanOptions& manhattan = {});

}  // namespace waystone
