// SPDX-License-Identifier: Apache-2.0
#include "builder/extract_frames.h"

#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <opencv2/imgproc.hpp>

#include "core/base/clock.h"

namespace waystone {
namespace {

cv::Mat Thumbnail(const cv::Mat& grey, int width) {
  if (grey.cols <= width) return grey;
  cv::Mat small;
  const int height = std::max(
      1, static_cast<int>(std::lround(static_cast<double>(grey.rows) * width / grey.cols)));
  cv::resize(grey, small, {width, height}, 0, 0, cv::INTER_AREA);
  return small;
}

WorkedFrame Work(const EncodedFrame& encoded, const ExtractFramesOptions& options) {
  WorkedFrame worked;
  const Clock::time_point start = Clock::now();
  Frame frame = encoded.Decode();
  worked.decode_s = SecondsSince(start);
  worked.frame.info = std::move(frame.info);
  worked.error = std::move(frame.error);
  if (frame.grey.empty()) return worked;
  const Clock::time_point decoded = Clock::now();
  worked.frame.features = ExtractFeatures(frame.grey, options.features);
  if (options.thumbnail_width > 0) {
    worked.frame.thumbnail = Thumbnail(frame.grey, options.thumbnail_width);
  }
  worked.extract_s = SecondsSince(decoded);
  return worked;
}

}  // namespace

void ExtractFrames(Source& source, const ExtractFramesOptions& options,
                   const std::function<bool(WorkedFrame)>& consume) {
  std::atomic<bool> stopped = false;  // the pipeline's ends run on different threads
  // Two frames a worker: enough that none waits, few enough that memory stays bounded.
  const size_t in_flight = 2 * static_cast<size_t>(tbb::this_task_arena::max_concurrency()) + 1;
  tbb::parallel_pipeline(
      in_flight,
      tbb::make_filter<void, std::shared_ptr<EncodedFrame>>(
          tbb::filter_mode::serial_in_order,
          [&](tbb::flow_control& control) -> std::shared_ptr<EncodedFrame> {
            std::optional<EncodedFrame> next;
            if (!stopped) next = source.NextEncoded();
            if (next) return std::make_shared<EncodedFrame>(std::move(*next));
            control.stop();
            return nullptr;
          }) &
          tbb::make_filter<std::shared_ptr<EncodedFrame>, std::shared_ptr<WorkedFrame>>(
              tbb::filter_mode::parallel,
              [&](const std::shared_ptr<EncodedFrame>& encoded) {
                return std::make_shared<WorkedFrame>(Work(*encoded, options));
              }) &
          tbb::make_filter<std::shared_ptr<WorkedFrame>, void>(
              tbb::filter_mode::serial_in_order, [&](const std::shared_ptr<WorkedFrame>& worked) {
                if (!stopped && !consume(std::move(*worked))) stopped = true;
              }));
}

}  // namespace waystone
