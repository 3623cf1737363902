// SPDX-License-Identifier: Apache-2.0
#include "builder/appearance/describe_frames.h"

#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/clock.h"
#include "core/base/error.h"

namespace waystone {
namespace {

constexpr double kPanoramaAspect = 2;
constexpr double kAspectTolerance = 0.02;
constexpr int kSmallestImage_px = 16;
constexpr int kLargestImage_px = 4096;
constexpr int kBestQuality = 100;

std::vector<uint8_t> SmallJpeg(const cv::Mat& grey, const DescribeOptions& options) {
  cv::Mat small = grey;
  if (grey.cols > options.image_width) {
    const double share = static_cast<double>(options.image_width) / grey.cols;
    const int height = std::max(1, static_cast<int>(std::lround(grey.rows * share)));
    cv::resize(grey, small, {options.image_width, height}, 0, 0, cv::INTER_AREA);
  }
  std::vector<uint8_t> jpeg;
  cv::imencode(".jpg", small, jpeg, {cv::IMWRITE_JPEG_QUALITY, options.image_quality});
  return jpeg;
}

bool IsWholeSphere(const Panorama& panorama) {
  return panorama.band == ElevationBand{} && panorama.grey.cols == 2 * panorama.grey.rows;
}

DescribedFrame Describe(const EncodedFrame& encoded, const DescribeOptions& options) {
  DescribedFrame described;
  const Clock::time_point start = Clock::now();
  Frame frame = encoded.Decode();
  described.decode_s = SecondsSince(start);
  described.info = std::move(frame.info);
  described.error = std::move(frame.error);
  if (frame.grey.empty()) return described;
  const Clock::time_point decoded = Clock::now();
  try {
    const Panorama panorama = ToPanorama(frame.grey, options.panorama);
    described.signature = Signature(panorama, options.signature);
    SignatureOptions of_trajectory = options.signature;
    of_trajectory.rows = options.trajectory_rows;
    described.trajectory_signature = Signature(panorama, of_trajectory);
    described.band = UsedBand(panorama, options.signature);
    if (options.features.max_kept > 0 && IsWholeSphere(panorama)) {
      described.features = ExtractPanoramaFeatures(panorama.grey, options.features.extract);
    }
    if (options.image_width > 0) described.jpeg = SmallJpeg(panorama.grey, options);
  } catch (const MapError& error) {
    described.error = error.what();
  }
  described.describe_s = SecondsSince(decoded);
  return described;
}

[[noreturn]] void RefuseOption(const std::string& message) {
  throw MapError(ErrorCode::kBadOptions, message);
}

}  // namespace

void DescribeOptions::Check() const {
  panorama.Check();
  signature.Check();
  features.Check();
  SignatureOptions of_trajectory = signature;
  of_trajectory.rows = trajectory_rows;
  of_trajectory.Check();
  if (image_width != 0 && (image_width < kSmallestImage_px || image_width > kLargestImage_px)) {
    RefuseOption("image_width is " + std::to_string(image_width) +
                 "; it must be 0, or between 16 and 4096");
  }
  if (image_quality < 1 || image_quality > kBestQuality) {
    RefuseOption("image_quality is " + std::to_string(image_quality) +
                 "; it must be between 1 and 100");
  }
}

bool LooksPanoramic(const Source& source) {
  if (source.kind() == "rig") return true;
  const cv::Size size = source.frame_size();
  return size.height > 0 &&
         std::abs(size.width / (kPanoramaAspect * size.height) - 1) <= kAspectTolerance;
}

void DescribeFrames(Source& source, const DescribeOptions& options,
                    const std::function<bool(DescribedFrame)>& consume) {
  using Encoded = std::shared_ptr<EncodedFrame>;
  using Described = std::shared_ptr<DescribedFrame>;
  std::atomic<bool> stopped = false;  // the pipeline's ends run on different threads
  // Two frames a worker: enough that none waits, few enough that memory stays bounded.
  const size_t in_flight = 2 * static_cast<size_t>(tbb::this_task_arena::max_concurrency()) + 1;
  const auto read = [&](tbb::flow_control& control) -> Encoded {
    std::optional<EncodedFrame> next;
    if (!stopped) next = source.NextEncoded();
    if (next) return std::make_shared<EncodedFrame>(std::move(*next));
    control.stop();
    return nullptr;
  };
  const auto describe = [&](const Encoded& encoded) {
    return std::make_shared<DescribedFrame>(Describe(*encoded, options));
  };
  const auto hand_over = [&](const Described& described) {
    if (!stopped && !consume(std::move(*described))) stopped = true;
  };
  tbb::parallel_pipeline(
      in_flight,
      tbb::make_filter<void, Encoded>(tbb::filter_mode::serial_in_order, read) &
          tbb::make_filter<Encoded, Described>(tbb::filter_mode::parallel, describe) &
          tbb::make_filter<Described, void>(tbb::filter_mode::serial_in_order, hand_over));
}

}  // namespace waystone
