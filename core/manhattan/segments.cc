// SPDX-License-Identifier: Apache-2.0
#include "core/manhattan/segments.h"

#include <algorithm>
#include <array>
#include <opencv2/imgproc.hpp>
#include <opencv2/ximgproc/edge_drawing.hpp>
#include <optional>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/manhattan/edge_chains.h"
#include "core/manhattan/refine_segment.h"

namespace waystone {
namespace {

struct NamedDetector {
  SegmentDetector detector;
  std::string_view name;
};

constexpr std::array kDetectors{
    NamedDetector{SegmentDetector::kEdgeDrawing, "edge_drawing"},
    NamedDetector{SegmentDetector::kCanny, "canny"},
    NamedDetector{SegmentDetector::kLsd, "lsd"},
};

std::vector<ImageSegment> FromVectors(const std::vector<cv::Vec4f>& lines) {
  std::vector<ImageSegment> segments;
  segments.reserve(lines.size());
  for (const cv::Vec4f& line : lines) {
    segments.push_back({Eigen::Vector2d(line[0], line[1]), Eigen::Vector2d(line[2], line[3])});
  }
  return segments;
}

std::vector<ImageSegment> ByEdgeDrawing(const cv::Mat& grey, double min_length_px,
                                        const SegmentOptions& options) {
  // A new one per call, although each leaks 36 bytes (OpenCV 4.6): a reused one keeps state, and
  // gave other lines for a third of the images.
  const auto detector = cv::ximgproc::createEdgeDrawing();
  // OpenCV sums the differences of three rows for a gradient (Prewitt).
  constexpr int kPrewittSum = 3;
  detector->params.EdgeDetectionOperator = cv::ximgproc::EdgeDrawing::PREWITT;
  detector->params.GradientThresholdValue = kPrewittSum * options.min_gradient;
  detector->params.MinPathLength = static_cast<int>(min_length_px);
  detector->params.MinLineLength = static_cast<int>(min_length_px);
  detector->params.Sigma = static_cast<float>(options.blur_px);
  detector->params.LineFitErrorThreshold = options.max_bend_px;
  detector->detectEdges(grey);
  std::vector<cv::Vec4f> lines;
  detector->detectLines(lines);
  return FromVectors(lines);
}

std::vector<ImageSegment> ByCanny(const cv::Mat& grey, double min_length_px,
                                  const SegmentOptions& options) {
  cv::Mat smooth;
  cv::GaussianBlur(grey, smooth, {}, options.blur_px);
  // Sobel's kernel weighs a gradient by 8 over two pixels; edges go on at half of what starts them.
  constexpr int kSobelSum = 8;
  const double start = kSobelSum * options.min_gradient;
  cv::Mat edges;
  cv::Canny(smooth, edges, 0.5 * start, start, 3, true);
  return StraightPieces(LinkEdges(edges), options.max_bend_px, min_length_px);
}

std::vector<ImageSegment> ByLsd(const cv::Mat& grey) {
  std::vector<cv::Vec4f> lines;
  cv::createLineSegmentDetector()->detect(grey, lines);
  return FromVectors(lines);
}

std::vector<ImageSegment> Detect(const cv::Mat& grey, double min_length_px,
                                 const SegmentOptions& options) {
  switch (options.detector) {
    case SegmentDetector::kCanny:
      return ByCanny(grey, min_length_px, options);
    case SegmentDetector::kLsd:
      return ByLsd(grey);
    default:
      return ByEdgeDrawing(grey, min_length_px, options);
  }
}

}  // namespace

std::string_view NameOf(SegmentDetector detector) {
  const auto row = std::ranges::find(kDetectors, detector, &NamedDetector::detector);
  WS_CHECK(row != kDetectors.end(), "unknown segment detector");
  return row->name;
}

void ParseOptionValue(const std::string& path, const std::string& text, SegmentDetector* value) {
  const auto row = std::ranges::find(kDetectors, text, &NamedDetector::name);
  if (row == kDetectors.end()) {
    throw MapError(ErrorCode::kBadOptions,
                   path + " is '" + text + "'; it must be edge_drawing, canny or lsd");
  }
  *value = row->detector;
}

SegmentDetector SegmentDetectorByName(std::string_view name) {
  SegmentDetector detector{};
  ParseOptionValue("the segment detector", std::string(name), &detector);
  return detector;
}

void SegmentOptions::Check() const { CheckFields("segments", *this); }

std::vector<ImageSegment> DetectSegments(const cv::Mat& grey, const SegmentOptions& options) {
  options.Check();
  WS_CHECK(grey.type() == CV_8UC1, "segments are looked for in 8-bit grey images");
  constexpr int kLeastSide = 16;  // px; OpenCV's detectors want some room
  if (std::min(grey.rows, grey.cols) < kLeastSide) return {};
  const double min_length_px = std::max(4.0, options.min_length * std::max(grey.rows, grey.cols));
  std::vector<ImageSegment> found = Detect(grey, min_length_px, options);
  std::erase_if(found, [&](const ImageSegment& s) { return s.length_px() < min_length_px; });
  if (!options.refine) return found;
  std::vector<ImageSegment> refined;
  for (const ImageSegment& segment : found) {
    const auto better = RefineSegment(grey, segment, options.refine_reach_px);
    if (better && better->length_px() >= min_length_px) refined.push_back(*better);
  }
  return refined;
}

}  // namespace waystone
