// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string_view>
#include <vector>

#include "core/base/options.h"

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
// The same for an option; `path` is its name.
void ParseOptionValue(const std::string& path, const std::string& text, SegmentDetector* value);

// A straight edge of an image between two points. Pixels, (0, 0) is the centre of the top left one.
struct ImageSegment {
  Eigen::Vector2d a;
  Eigen::Vector2d b;

  double length_px() const { return (b - a).norm(); }
};

struct SegmentOptions {
  SegmentDetector detector = SegmentDetector::kEdgeDrawing;
  double min_length = 0.03;
  double blur_px = 1.0;
  int min_gradient = 10;
  double max_bend_px = 1.0;
  bool refine = true;
  double refine_reach_px = 2.0;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"detector", &SegmentOptions::detector, AnyValue(), "",
                    "Line segment detector: edge_drawing, canny or lsd."},
        OptionField{
            "min_length", &SegmentOptions::min_length, Closed(0.005, 0.5), "",
            "Minimum length of a segment, as a share of the image's longer side. Short segments "
            "are numerous and have arbitrary directions; long ones may be too few."},
        OptionField{"blur_px", &SegmentOptions::blur_px, Closed(0.3, 5), "px",
                    "Standard deviation of the blur before edge detection (edge drawing and "
                    "Canny). Higher values find fewer, more stable edges."},
        OptionField{"min_gradient", &SegmentOptions::min_gradient, Closed(1, 255), "",
                    "Minimum gradient of an edge pixel, in grey levels per pixel. Lower values "
                    "find fainter lines, but also more noise. LSD has its own threshold."},
        OptionField{"max_bend_px", &SegmentOptions::max_bend_px, Closed(0.3, 5), "px",
                    "Maximum distance of a chain of edge pixels from its straight line. Higher "
                    "values accept slightly curved edges."},
        OptionField{"refine", &SegmentOptions::refine, AnyValue(), "",
                    "Whether to refit each segment to the steepest gradient with sub-pixel "
                    "precision. Costs about a tenth of the detection time."},
        OptionField{"refine_reach_px", &SegmentOptions::refine_reach_px, Closed(1, 5), "px",
                    "Distance to either side within which the steepest gradient is searched for."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// Segments of an 8-bit grey image (CV_8UC1), none for one without straight edges. Deterministic;
// thread-safe.
std::vector<ImageSegment> DetectSegments(const cv::Mat& grey, const SegmentOptions& options = {});

}  // namespace waystone
