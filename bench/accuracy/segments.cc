// SPDX-License-Identifier: Apache-2.0
#include "core/manhattan/segments.h"

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "bench/accuracy/common.h"
#include "bench/accuracy/stopwatch.h"
#include "core/base/error.h"
#include "core/base/random.h"
#include "core/image/decode.h"

namespace waystone::bench {
namespace {

// The second view of an image: turned, and scaled down about its middle, with noise.
constexpr double kTurn = 7;       // degrees
constexpr double kScale = 0.85;   // of the first
constexpr double kNoise = 4;      // grey levels
constexpr double kNear = 1.5;     // px across, of a segment that is found again
constexpr double kOverlap = 0.5;  // of its length

struct View {
  cv::Mat image;
  cv::Matx23d from_first;
};

View SecondView(const cv::Mat& grey, uint64_t seed) {
  View view;
  const cv::Point2f middle(0.5F * static_cast<float>(grey.cols - 1),
                           0.5F * static_cast<float>(grey.rows - 1));
  view.from_first = cv::Matx23d(cv::getRotationMatrix2D(middle, kTurn, kScale));
  cv::warpAffine(grey, view.image, view.from_first, grey.size(), cv::INTER_AREA,
                 cv::BORDER_REPLICATE);
  Random random(seed);
  for (int y = 0; y < view.image.rows; ++y) {
    for (int x = 0; x < view.image.cols; ++x) {
      uchar& pixel = view.image.at<uchar>(y, x);
      pixel = cv::saturate_cast<uchar>(pixel + kNoise * random.Normal());
    }
  }
  return view;
}

ImageSegment Moved(const ImageSegment& segment, const cv::Matx23d& m) {
  const auto move = [&](const Eigen::Vector2d& p) {
    return Eigen::Vector2d(m(0, 0) * p.x() + m(0, 1) * p.y() + m(0, 2),
                           m(1, 0) * p.x() + m(1, 1) * p.y() + m(1, 2));
  };
  return {move(segment.a), move(segment.b)};
}

// Whether `other` lies on the segment's line, along enough of it.
bool IsSame(const ImageSegment& segment, const ImageSegment& other) {
  const double length = segment.length_px();
  const Eigen::Vector2d along = (segment.b - segment.a) / length;
  const auto place = [&](const Eigen::Vector2d& p) -> Eigen::Vector2d {
    const Eigen::Vector2d offset = p - segment.a;
    return {along.dot(offset), along.x() * offset.y() - along.y() * offset.x()};
  };
  const Eigen::Vector2d a = place(other.a);
  const Eigen::Vector2d b = place(other.b);
  if (std::abs(a.y()) > kNear || std::abs(b.y()) > kNear) return false;
  const double overlap =
      std::min(std::max(a.x(), b.x()), length) - std::max(std::min(a.x(), b.x()), 0.0);
  return overlap >= kOverlap * length;
}

struct Result {
  double repeated_px = 0;  // length of segments that were found again
  double all_px = 0;
  int segments = 0;
  std::vector<double> ms;
};

void Add(Result& result, const cv::Mat& grey, const View& second, SegmentDetector detector) {
  const SegmentOptions options{.detector = detector};
  const Stopwatch watch;
  const std::vector<ImageSegment> first = DetectSegments(grey, options);
  const double ms = 1e3 * watch.cpu_s();
  const std::vector<ImageSegment> again = DetectSegments(second.image, options);
  const cv::Rect2d inside(0, 0, grey.cols - 1, grey.rows - 1);
  for (const ImageSegment& segment : first) {
    const ImageSegment there = Moved(segment, second.from_first);
    if (!inside.contains({there.a.x(), there.a.y()}) ||
        !inside.contains({there.b.x(), there.b.y()})) {
      continue;
    }
    const bool found =
        std::ranges::any_of(again, [&](const ImageSegment& other) { return IsSame(there, other); });
    result.all_px += segment.length_px();
    result.repeated_px += found ? segment.length_px() : 0;
  }
  result.segments += static_cast<int>(first.size());
  result.ms.push_back(ms);
}

}  // namespace

int RunSegments(const Args& args) {
  if (args.empty()) throw MapError(ErrorCode::kUsage, "segments wants images or folders");
  std::vector<cv::Mat> images;
  for (const std::string& path : args) {
    for (const auto& image : ImagesIn(path)) images.push_back(DecodeGrey(ReadBytes(image)));
  }
  if (images.empty()) throw MapError(ErrorCode::kBadSource, "no image there");
  std::printf("%-14s %10s %12s %8s\n", "detector", "segments", "repeated", "ms");
  nlohmann::ordered_json rows = nlohmann::ordered_json::object();
  for (const SegmentDetector detector :
       {SegmentDetector::kEdgeDrawing, SegmentDetector::kCanny, SegmentDetector::kLsd}) {
    Result result;
    for (size_t i = 0; i < images.size(); ++i) {
      Add(result, images[i], SecondView(images[i], i), detector);
    }
    const double repeated = result.all_px > 0 ? result.repeated_px / result.all_px : 0;
    const double count = static_cast<double>(result.segments) / static_cast<double>(images.size());
    const std::string name(NameOf(detector));
    std::printf("%-14s %10.0f %11.1f%% %8.1f\n", name.c_str(), count, 100 * repeated,
                Quantile(result.ms, 0.5));
    rows[name] = {{"segments_per_image", count},
                  {"repeated_share_of_length", repeated},
                  {"ms_median", Quantile(result.ms, 0.5)}};
  }
  std::cout << nlohmann::ordered_json{{"bench", "segments"}, {"detectors", rows}}.dump()
            << std::endl;
  return 0;
}

}  // namespace waystone::bench
