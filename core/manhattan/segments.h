// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string_view>
#include <vector>

namespace waystone {

// How straight segments are found.
enum class SegmentDetector {
  kEdgeDrawing,  // Akinlar and Topal's edge drawing and EDLines
  kCanny,        // Canny's edges linked into chains and cut where they bend (sec. II-A)
  kLsd,          // von Gioi's line segment detector
};

// "edge_drawing", "canny", "lsd".
std::string_view NameOf(SegmentDetector detector);
// Throws MapError(kBadOptions) for another name.
SegmentDetector SegmentDetectorByName(std::string_view name);

// A straight edge of an image between two points. Pixels, (0, 0) is the centre of the top left one.
struct ImageSegment {
  Eigen::Vector2d a;
  Eigen::Vector2d b;

  double length_px() const { return (b - a).norm(); }
};

struct SegmentOptions {
  SegmentDetector detector = SegmentDetector::kEdgeDrawing;
  // Shortest segment that is kept, as a share of the image's longer side, 0.005 to 0.5. Shorter
  // ones are many and point anywhere; longer ones may be too few.
  double min_length = 0.03;
  // Standard sigma of the blur before edges are looked for (edge drawing and Canny), 0.3 to 5.
  // More blur finds fewer, steadier edges. px
  double blur_px = 1.0;
  // Least gradient of an edge pixel, grey levels a pixel, 1 to 255. Lower finds fainter lines and
  // more noise. (LSD has its own.)
  int min_gradient = 10;
  // How far a chain of edge pixels may lie from its straight line, 0.3 to 5. Higher takes slightly
  // bent edges for straight ones. px
  double max_bend_px = 1.0;
  // Whether each segment is laid anew along the steepest gradient with sub-pixel precision. Costs
  // about a tenth of the detection.
  bool refine = true;
  // How far to both sides the steepest gradient is looked for, 1 to 5. px
  double refine_reach_px = 2.0;

  void Check() const;  // throws MapError(kBadOptions)
};

// Segments of an 8-bit grey image (CV_8UC1), none for one without straight edges. Deterministic;
// thread-safe.
std::vector<ImageSegment> DetectSegments(const cv::Mat& grey, const SegmentOptions& options = {});

}  // namespace waystone
