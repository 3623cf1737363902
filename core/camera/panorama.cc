// SPDX-License-Identifier: Apache-2.0
#include "core/camera/panorama.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/geometry/angle.h"
#include "core/robust/median.h"

namespace waystone {
namespace {

constexpr int kMinColumns = 64;
constexpr int kMinRows = 8;
constexpr int kMaxMirror_px = 65'536;      // of a mirror's radius and centre
constexpr int kStripRows = 64;             // unwrapped at once
constexpr double kMinBand_rad = 0.01;      // of a mirror: rows must be apart
constexpr double kMinSigma = 1;            // grey levels: below this an image shows nothing
constexpr double kAspectTolerance = 0.02;  // of twice as wide as high
constexpr double kUsualColumns = 0.98;     // share of the columns whose differences are usual
// The mirror's search covers the usual designs and framings of such cameras, which bounds the time;
// other images can name their mirror (PanoramaOptions::mirror).
constexpr int kCoarseSide_px = 96;  // the first of the sides that are searched
constexpr int kAngles = 90;         // around a circle: one to four pixels apart at the coarse side
constexpr double kReach_share = 0.2;       // of the side: how far its centre lies from the image's
constexpr double kMinOuter_share = 0.2;    // of the side: a smaller mirror wastes most of the image
constexpr double kMaxOuter_share = 0.52;   // touches the image's edges, a little cut off
constexpr double kMinUniform_share = 0.8;  // of the circumference: see UniformOutside
constexpr double kMaxInner_share = 0.5;    // of the outer radius: more leaves a ring without a view
constexpr double kMinInner_share = 0.08;  // of the outer radius: the camera's own picture is larger
constexpr double kUsualInner_share = 0.25;  // of the outer radius, where no inner edge is found

[[noreturn]] void RefusePanorama(const std::string& message) {
  throw MapError(ErrorCode::kBadImage, message);
}

std::string Rounded(double value) {
  const std::string text = std::to_string(value);
  return text.substr(0, text.find('.') + 2);
}

std::string SizeOf(const cv::Mat& image) { return SizeText(image.cols, image.rows); }

cv::Mat GreyOf(const cv::Mat& image) {
  WS_CHECK(image.type() == CV_8UC1 || image.type() == CV_8UC3 || image.type() == CV_8UC4,
           "an image of another type than 8-bit grey, BGR or BGRA");
  if (image.channels() == 1) return image;
  cv::Mat grey;
  cv::cvtColor(image, grey, image.channels() == 3 ? cv::COLOR_BGR2GRAY : cv::COLOR_BGRA2GRAY);
  return grey;
}

void CheckContent(const cv::Mat& grey) {
  if (grey.cols < kMinColumns || grey.rows < kMinRows) {
    RefusePanorama("the image has " + SizeOf(grey) +
                   " pixels, too few for a panorama; the minimum is " +
                   std::to_string(kMinColumns) + "x" + std::to_string(kMinRows));
  }
  cv::Scalar mean;
  cv::Scalar sigma;
  cv::meanStdDev(grey, mean, sigma);
  if (sigma[0] < kMinSigma) {
    RefusePanorama("the image has no content: all grey levels are close to " + Rounded(mean[0]) +
                   "; uncover the lens or increase the exposure");
  }
}

// Sums of the differences between each column and the next, the last one's to the first; row by
// row, as the pixels lie.
std::vector<int64_t> ColumnDifferences(const cv::Mat& grey) {
  std::vector<int32_t> sums(grey.cols, 0);  // 255 times the rows of any image fit
  const int last = grey.cols - 1;
  for (int y = 0; y < grey.rows; ++y) {
    const auto* row = grey.ptr<uint8_t>(y);
    for (int x = 0; x < last; ++x) sums[x] += std::abs(row[x + 1] - row[x]);
    sums[last] += std::abs(row[0] - row[last]);
  }
  return {sums.begin(), sums.end()};
}

float ValueAt(const cv::Mat& grey, const cv::Point2d& at) {
  const int x = std::clamp(cvRound(at.x), 0, grey.cols - 1);
  const int y = std::clamp(cvRound(at.y), 0, grey.rows - 1);
  return grey.at<uint8_t>(y, x);
}

// Calls visit(inside, outside) with the grey levels beside a circle, at each angle where both are
// in the image.
template <class Visit>
void VisitCircle(const cv::Mat& grey, const cv::Point2d& centre, double radius,
                 const Visit& visit) {
  constexpr double kBeside_px = 1.5;
  for (int i = 0; i < kAngles; ++i) {
    const cv::Point2d ray(std::cos(2 * kPi * i / kAngles), std::sin(2 * kPi * i / kAngles));
    const cv::Point2d outside = centre + ray * (radius + kBeside_px);
    if (outside.x < 0 || outside.y < 0 || outside.x > grey.cols - 1 || outside.y > grey.rows - 1) {
      continue;
    }
    visit(ValueAt(grey, centre + ray * (radius - kBeside_px)), ValueAt(grey, outside));
  }
}

// How much brighter the image is just inside a circle than just outside; parts outside the image
// count as no difference.
double ComputeContrast(const cv::Mat& grey, const cv::Point2d& centre, double radius) {
  double sum = 0;
  VisitCircle(grey, centre, radius,
              [&sum](double inside, double outside) { sum += inside - outside; });
  return sum / kAngles;
}

struct Circle {
  cv::Point2d centre;
  double radius = 0;
  double contrast = -1e9;
};

// The best circle within `reach` of the given centre, with radii from low to high, in steps.
Circle BestCircle(const cv::Mat& grey, const cv::Point2d& around, double reach, double low,
                  double high, double step) {
  Circle best;
  for (double y = around.y - reach; y <= around.y + reach; y += step) {
    for (double x = around.x - reach; x <= around.x + reach; x += step) {
      for (double radius = low; radius <= high; radius += step) {
        const double contrast = ComputeContrast(grey, {x, y}, radius);
        if (contrast > best.contrast) best = {{x, y}, radius, contrast};
      }
    }
  }
  return best;
}

// Coarse-to-fine: all circles on a small image, then the neighbours of the best on larger ones.
Circle FindCircle(const cv::Mat& grey) {
  const int side = std::min(grey.cols, grey.rows);
  double scale = std::min(1.0, static_cast<double>(kCoarseSide_px) / side);
  const auto level = [&] {
    cv::Mat small;
    cv::resize(grey, small, {}, scale, scale, cv::INTER_AREA);
    return small;
  };
  cv::Mat small = level();
  const double small_side = side * scale;
  Circle circle = BestCircle(small, {small.cols / 2.0, small.rows / 2.0}, kReach_share * small_side,
                             kMinOuter_share * small_side, kMaxOuter_share * small_side, 2);
  circle = BestCircle(small, circle.centre, 2, circle.radius - 2, circle.radius + 2, 0.5);
  while (scale < 1) {
    const double finer = std::min(1.0, 2 * scale);
    const double factor = finer / scale;
    scale = finer;
    small = level();
    circle = BestCircle(small, circle.centre * factor, 2, circle.radius * factor - 2,
                        circle.radius * factor + 2, 1);
  }
  return circle;
}

// The share of a circle's circumference just outside which the image has nearly one brightness. A
// mirror is mounted in front of something dark; around a circle in a photo the scene goes on.
double UniformOutside(const cv::Mat& grey, const Circle& circle) {
  constexpr double kNear = 12;  // grey levels
  std::vector<double> values;
  VisitCircle(grey, circle.centre, circle.radius,
              [&values](double, double outside) { values.push_back(outside); });
  const double median = Median(values);
  const auto near = std::ranges::count_if(
      values, [median](double value) { return std::abs(value - median) <= kNear; });
  return static_cast<double>(near) / static_cast<double>(values.size());
}

// The strongest edge of either sign around the same centre.
double InnerRadius(const cv::Mat& grey, const Circle& outer, double min_contrast) {
  double best = min_contrast;
  double radius = kUsualInner_share * outer.radius;
  for (double r = kMinInner_share * outer.radius; r < kMaxInner_share * outer.radius; ++r) {
    const double contrast = std::abs(ComputeContrast(grey, outer.centre, r));
    if (contrast <= best) continue;
    best = contrast;
    radius = r;
  }
  return radius;
}

double AspectOf(const cv::Size& size) { return static_cast<double>(size.width) / size.height; }

void CheckSeam(const cv::Mat& grey, double max_seam) {
  const double ratio = SeamRatio(grey);
  if (ratio <= max_seam) return;
  RefusePanorama("the image does not cover 360 degrees: its left and right edges differ " +
                 Rounded(ratio) + " times as much as neighbouring columns, more than " +
                 Rounded(max_seam) + "; use a full panorama, or increase max_seam");
}

void CheckRing(const MirrorRing& mirror) {
  if (!(mirror.inner_px >= 0 && mirror.outer_px >= mirror.inner_px + 1 &&
        mirror.outer_px <= kMaxMirror_px)) {
    throw MapError(ErrorCode::kBadOptions,
                   "the mirror's radii are " + Rounded(mirror.inner_px) + " and " +
                       Rounded(mirror.outer_px) +
                       " px; the inner must be smaller than the outer, which is at most " +
                       std::to_string(kMaxMirror_px) + " px");
  }
  if (!(std::abs(mirror.centre_px.x) <= kMaxMirror_px &&
        std::abs(mirror.centre_px.y) <= kMaxMirror_px)) {
    throw MapError(ErrorCode::kBadOptions,
                   "the mirror's centre is at " + Rounded(mirror.centre_px.x) + ", " +
                       Rounded(mirror.centre_px.y) + " px, more than " +
                       std::to_string(kMaxMirror_px) + " px from the image's corner");
  }
}

void CheckUnwrapped(const cv::Mat& grey, int rows, int columns) {
  constexpr int kMaxRemapped = std::numeric_limits<int16_t>::max() - 1;  // cv::remap's
  constexpr int64_t kMaxPixels = 64'000'000;
  if (std::max(grey.cols, grey.rows) > kMaxRemapped) {
    RefusePanorama("the mirror's image of " + SizeOf(grey) +
                   " pixels has a side over the limit of " + std::to_string(kMaxRemapped) +
                   "; downscale it");
  }
  if (int64_t{rows} * columns > kMaxPixels) {
    RefusePanorama("the mirror's image of " + SizeOf(grey) + " pixels would become a panorama of " +
                   std::to_string(columns) + "x" + std::to_string(rows) +
                   ", more than the limit of " + std::to_string(kMaxPixels) +
                   " pixels; downscale it, or use fewer columns");
  }
}

}  // namespace

void PanoramaOptions::Check() const {
  CheckFields("panorama", *this);
  if (mirror_band.bottom_rad > mirror_band.top_rad - kMinBand_rad) {
    throw MapError(ErrorCode::kBadOptions,
                   "panorama.mirror_band.bottom_rad is " + std::to_string(mirror_band.bottom_rad) +
                       "; it must be below top_rad, " + std::to_string(mirror_band.top_rad));
  }
  if (mirror) CheckRing(*mirror);
}

bool BandsAgree(const ElevationBand& a, const ElevationBand& b) {
  constexpr double kTolerance_rad = 1e-6;
  return std::abs(a.top_rad - b.top_rad) <= kTolerance_rad &&
         std::abs(a.bottom_rad - b.bottom_rad) <= kTolerance_rad;
}

bool HasPanoramaShape(const cv::Size& size) {
  return size.height > 0 && std::abs(AspectOf(size) / 2 - 1) <= kAspectTolerance;
}

PanoramaKind KindOf(const cv::Mat& image, const PanoramaOptions& options) {
  if (options.mirror) return PanoramaKind::kMirror;
  if (HasPanoramaShape(image.size())) return PanoramaKind::kEquirectangular;
  return AspectOf(image.size()) > 2 ? PanoramaKind::kStrip : PanoramaKind::kMirror;
}

double SeamRatio(const cv::Mat& grey) {
  std::vector<int64_t> differences = ColumnDifferences(grey);
  const auto seam = static_cast<double>(differences.back()) / grey.rows;
  differences.pop_back();
  const auto usual = differences.begin() + static_cast<std::ptrdiff_t>(
                                               kUsualColumns * static_cast<double>(grey.cols - 2));
  std::nth_element(differences.begin(), usual, differences.end());
  return seam / std::max(static_cast<double>(*usual) / grey.rows, 1.0);
}

MirrorRing FindMirror(const cv::Mat& grey, const PanoramaOptions& options) {
  options.Check();
  WS_CHECK(grey.type() == CV_8UC1, "a mirror's image must be grey");
  const Circle outer = FindCircle(grey);
  const bool stands_out = outer.contrast >= options.min_mirror_contrast;
  const double uniform = stands_out ? UniformOutside(grey, outer) : 0;
  if (uniform < kMinUniform_share) {
    const std::string cause =
        stands_out
            ? "only " + std::to_string(cvRound(100 * uniform)) +
                  " % of what surrounds its best circle has nearly one brightness, less than " +
                  std::to_string(cvRound(100 * kMinUniform_share)) + " %"
            : "its best circle has a contrast of " + Rounded(outer.contrast) + ", less than " +
                  Rounded(options.min_mirror_contrast);
    RefusePanorama("the image of " + SizeOf(grey) +
                   " pixels is neither a panorama (twice as wide as high) nor a mirror image (" +
                   cause +
                   "); use a 360-degree image, or specify the centre and radii of the mirror");
  }
  return {outer.centre, InnerRadius(grey, outer, options.min_mirror_contrast), outer.radius};
}

Panorama Unwrap(const cv::Mat& grey, const MirrorRing& mirror, const PanoramaOptions& options) {
  options.Check();
  CheckRing(mirror);
  const double height = mirror.outer_px - mirror.inner_px;
  const int rows = std::max(kMinRows, cvRound(height));
  CheckUnwrapped(grey, rows, options.columns);
  Panorama panorama;
  panorama.band = options.mirror_band;
  panorama.grey.create(rows, options.columns, CV_8UC1);
  // In strips: a pixel's source coordinates take eight times as much memory as the pixel.
  for (int top = 0; top < rows; top += kStripRows) {
    cv::Mat strip = panorama.grey.rowRange(top, std::min(rows, top + kStripRows));
    cv::Mat from(strip.size(), CV_32FC2);
    for (int y = 0; y < strip.rows; ++y) {
      const double radius = mirror.outer_px - (top + y + 0.5) * height / rows;
      for (int x = 0; x < options.columns; ++x) {
        const double azimuth = 2 * kPi * (x + 0.5) / options.columns - kPi;
        const double angle = options.mirror_clockwise ? azimuth : -azimuth;
        from.at<cv::Vec2f>(y, x) = {
            static_cast<float>(mirror.centre_px.x + radius * std::sin(angle)),
            static_cast<float>(mirror.centre_px.y - radius * std::cos(angle))};
      }
    }
    cv::remap(grey, strip, from, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  }
  return panorama;
}

Panorama ToPanorama(const cv::Mat& image, const PanoramaOptions& options) {
  options.Check();
  const cv::Mat grey = GreyOf(image);
  CheckContent(grey);
  switch (KindOf(grey, options)) {
    case PanoramaKind::kMirror:
      return Unwrap(grey, options.mirror ? *options.mirror : FindMirror(grey, options), options);
    case PanoramaKind::kStrip: {
      CheckSeam(grey, options.max_seam);
      const double half_rad = kPi / AspectOf(grey.size());
      return {grey, {half_rad, -half_rad}};
    }
    case PanoramaKind::kEquirectangular:
      break;
  }
  CheckSeam(grey, options.max_seam);
  return {grey, {}};
}

}  // namespace waystone
