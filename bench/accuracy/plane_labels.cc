// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/plane_labels.h"

namespace waystone::bench {

std::vector<int> LabelPlanes(const MatchedPoints& points, const PlaneLayerOptions& options) {
  const Segmentation segmentation = SegmentPlanes(points, {}, options.segmentation, options.seed);
  std::vector<int> labels(points.size(), 0);
  for (size_t p = 0; p < segmentation.planes.size(); ++p) {
    for (int row : segmentation.planes[p].rows) labels[row] = static_cast<int>(p) + 1;
  }
  return labels;
}

}  // namespace waystone::bench
