// SPDX-License-Identifier: Apache-2.0
#include "core/manhattan/refine_segment.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/geometry/linear_algebra.h"

namespace waystone {
namespace {

constexpr double kSampleStep = 0.5;  // px across the segment
constexpr int kMaxHalfSamples = 12;  // for the largest reach, with one more at each end
constexpr int kMaxPlaces = 96;       // along the segment: more add little
constexpr int kRefits = 4;
constexpr double kRobustScale = 0.5;  // px from the line at which a peak counts half

// Bilinear grey value, nothing outside the image.
std::optional<double> GreyAt(const cv::Mat& grey, const Eigen::Vector2d& at) {
  const double fx = std::floor(at.x());
  const double fy = std::floor(at.y());
  if (!(fx >= 0 && fy >= 0 && fx + 1 < grey.cols && fy + 1 < grey.rows)) return std::nullopt;
  const uchar* above = grey.ptr<uchar>(static_cast<int>(fy)) + static_cast<int>(fx);
  const uchar* below = above + grey.step;
  const double x = at.x() - fx;
  const double y = at.y() - fy;
  return (1 - y) * ((1 - x) * above[0] + x * above[1]) + y * ((1 - x) * below[0] + x * below[1]);
}

// A place on the segment: how far along it, and how far beside it the edge is.
struct Peak {
  double along_px = 0;
  double across_px = 0;
  double gradient = 0;  // signed, grey levels a pixel
};

// The steepest place on a profile across the segment.
std::optional<Peak> PeakAt(const cv::Mat& grey, const Eigen::Vector2d& centre,
                           const Eigen::Vector2d& across, int half) {
  std::array<double, 2 * kMaxHalfSamples + 1> values;
  for (int i = -half; i <= half; ++i) {
    const auto value = GreyAt(grey, centre + across * (i * kSampleStep));
    if (!value) return std::nullopt;
    values[i + half] = *value;
  }
  // Differences over two pixels, so that single noisy ones don't decide.
  constexpr int kSpan = 2;  // samples: one pixel to each side
  std::array<double, 2 * kMaxHalfSamples + 1> slopes{};
  const int count = 2 * half + 1;
  int best = kSpan;
  for (int i = kSpan; i < count - kSpan; ++i) {
    slopes[i] = (values[i + kSpan] - values[i - kSpan]) / (2 * kSpan * kSampleStep);
    if (std::abs(slopes[i]) > std::abs(slopes[best])) best = i;
  }
  if (best == kSpan || best == count - kSpan - 1 || slopes[best] == 0) return std::nullopt;
  const double before = std::abs(slopes[best - 1]);
  const double after = std::abs(slopes[best + 1]);
  const double curve = before + after - 2 * std::abs(slopes[best]);
  const double shift = curve < 0 ? 0.5 * (before - after) / curve : 0;
  return Peak{.across_px = (best - half + shift) * kSampleStep, .gradient = slopes[best]};
}

// across = offset + slope * along, by iteratively reweighted least squares (Cauchy).
Eigen::Vector2d FitRobustly(const std::vector<Peak>& peaks) {
  Eigen::Vector2d line = Eigen::Vector2d::Zero();
  for (int round = 0; round < kRefits; ++round) {
    Eigen::Matrix2d a = Eigen::Matrix2d::Zero();
    Eigen::Vector2d b = Eigen::Vector2d::Zero();
    for (const Peak& peak : peaks) {
      const Eigen::Vector2d row(1, peak.along_px);
      const double error = (peak.across_px - line.dot(row)) / kRobustScale;
      const double weight = 1 / (1 + error * error);
      a += weight * row * row.transpose();
      b += weight * peak.across_px * row;
    }
    line = SolveSymmetric(a, b);
  }
  return line;
}

std::vector<Peak> PeaksAlong(const cv::Mat& grey, const ImageSegment& segment, double reach_px,
                             int places) {
  const Eigen::Vector2d middle = 0.5 * (segment.a + segment.b);
  const Eigen::Vector2d along = (segment.b - segment.a).normalized();
  const Eigen::Vector2d across(-along.y(), along.x());
  const int half = std::min(kMaxHalfSamples, static_cast<int>(reach_px / kSampleStep) + 2);
  std::vector<Peak> peaks;
  for (int i = 0; i < places; ++i) {
    const double at = ((i + 0.5) / places - 0.5) * segment.length_px();
    auto peak = PeakAt(grey, middle + along * at, across, half);
    if (!peak) continue;
    peak->along_px = at;
    peaks.push_back(*peak);
  }
  return peaks;
}

}  // namespace

std::optional<ImageSegment> RefineSegment(const cv::Mat& grey, const ImageSegment& segment,
                                          double reach_px) {
  const double length = segment.length_px();
  const int places = std::clamp(static_cast<int>(length), 2, kMaxPlaces);
  std::vector<Peak> peaks = PeaksAlong(grey, segment, reach_px, places);
  double sign = 0;
  for (const Peak& peak : peaks) sign += peak.gradient;
  std::erase_if(peaks, [&](const Peak& peak) { return peak.gradient * sign <= 0; });
  if (2 * static_cast<int>(peaks.size()) < places || peaks.size() < 3) return std::nullopt;
  const Eigen::Vector2d line = FitRobustly(peaks);
  const Eigen::Vector2d middle = 0.5 * (segment.a + segment.b);
  const Eigen::Vector2d along = (segment.b - segment.a) / length;
  const Eigen::Vector2d across(-along.y(), along.x());
  const auto point = [&](double at) -> Eigen::Vector2d {
    return middle + along * at + across * (line[0] + line[1] * at);
  };
  return ImageSegment{point(-0.5 * length), point(0.5 * length)};
}

}  // namespace waystone
