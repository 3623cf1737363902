// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "core/manhattan/segments.h"

namespace waystone {

// Aligns a segment with the steepest gradient across it: at every pixel along the segment the peak
// of the gradient within `reach_px` on both sides is found to a fraction of a pixel, and a robust
// line is fitted to the peaks. The ends stay where they are along the line. Nothing when fewer than
// half of these places have a peak of the same sign: then it was no edge. Detectors round edges to
// whole pixels, which turns short segments by a degree. 8-bit grey image; thread-safe.
std::optional<ImageSegment> RefineSegment(const cv::Mat& grey, const ImageSegment& segment,
                                          double reach_px);

}  // namespace waystone
