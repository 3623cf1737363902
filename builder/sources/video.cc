// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "builder/sources/files.h"
#include "builder/sources/recognise.h"
#include "core/base/error.h"
#include "schema/sequence_kinds.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

// More than any video has; with as many left out, numbers of frames still are integers.
constexpr int kMostFrames = std::numeric_limits<int>::max() / 2;

cv::Mat Grey(const cv::Mat& image) {
  if (image.channels() == 1) return image;
  cv::Mat grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

[[noreturn]] void RefuseVideo(const fs::path& path, const std::string& cause) {
  throw MapError(
      ErrorCode::kBadSource,
      Quoted(path) + " can't be read as a video: " + cause +
          "; expected a folder of images, a video that FFmpeg can read, or a TUM, KITTI or "
          "EuRoC sequence");
}

// One decoder, front to back: a frame depends on those before it. Grabbing without retrieving skips
// the conversion to colours, which is most of the cost of a frame left out.
class VideoSource : public Source {
 public:
  VideoSource(const fs::path& path, const SourceOptions& options)
      : path_(path),
        name_(NameOfPath(path)),
        next_(options.from),
        every_(std::min(options.every, kMostFrames)),
        last_(std::min(options.to.value_or(kMostFrames), kMostFrames)) {
    Open(options.limits);
    if (!GrabUntil(options.from)) {
      RefuseVideo(path, "it has " + std::to_string(grabbed_ + 1) + " frames, none with index " +
                            std::to_string(options.from));
    }
    // The frame just grabbed shows that the header's count is at least that.
    frames_ = std::max(frames_, grabbed_ + 1);
    size_estimate_ = RangeOf(options, frames_, path.string()).size();
    if (!options.camera_file) return;
    camera_ = ReadCameraFile(*options.camera_file);
    CheckCameraSize(*camera_, size_.width, size_.height, path.string());
  }

  const std::string& kind() const override { return kind_; }
  const std::string& name() const override { return name_; }
  int size() const override { return size_estimate_; }
  const std::optional<Camera>& camera() const override { return camera_; }
  cv::Size frame_size() const override { return size_; }

  std::string Announcement() const override {
    return "Video, " + std::to_string(frames_) + (frames_ == 1 ? " frame " : " frames ") +
           std::to_string(size_.width) + "x" + std::to_string(size_.height) +
           UsedPart(size(), frames_);
  }

  // The header's count of frames is often wrong, so the end is where no frame comes any more.
  std::optional<EncodedFrame> NextEncoded() override {
    if (next_ > last_ || !GrabUntil(next_)) return std::nullopt;
    FrameInfo info{next_, "frame " + std::to_string(next_), TimeOfGrabbed()};
    next_ += every_;
    cv::Mat image = Retrieve();
    return EncodedFrame(std::move(info), [image = std::move(image), size = size_] {
      if (image.size() != size) {
        throw MapError(ErrorCode::kBadImage, "the frame can't be decoded; the video is damaged");
      }
      return Grey(image);
    });
  }

 private:
  void Open(const DecodeLimits& limits) {
    try {
      capture_.open(path_.string(), cv::CAP_FFMPEG);
    } catch (const cv::Exception& error) {
      RefuseVideo(path_, error.err);
    }
    if (!capture_.isOpened()) RefuseVideo(path_, "FFmpeg finds no video stream");
    // As in images, pixels stay where the camera put them: calibrations refer to that.
    capture_.set(cv::CAP_PROP_ORIENTATION_AUTO, 0);
    size_ = {static_cast<int>(capture_.get(cv::CAP_PROP_FRAME_WIDTH)),
             static_cast<int>(capture_.get(cv::CAP_PROP_FRAME_HEIGHT))};
    CheckLimits({.format = "video", .width = size_.width, .height = size_.height}, limits);
    const double frames = capture_.get(cv::CAP_PROP_FRAME_COUNT);
    frames_ =
        frames >= 1 && frames < std::numeric_limits<int>::max() ? static_cast<int>(frames) : 0;
  }

  bool GrabUntil(int number) {
    while (grabbed_ < number) {
      if (!capture_.grab()) return false;
      ++grabbed_;
    }
    return true;
  }

  std::optional<double> TimeOfGrabbed() const {
    constexpr double kSecondsPerMillisecond = 1e-3;
    const double time_ms = capture_.get(cv::CAP_PROP_POS_MSEC);
    if (grabbed_ > 0 && !(time_ms > 0)) return std::nullopt;  // a stream without time stamps
    return time_ms * kSecondsPerMillisecond;
  }

  cv::Mat Retrieve() {
    cv::Mat image;  // a new one each time: frames are still in use when the next one comes
    try {
      if (!capture_.retrieve(image)) return {};
    } catch (const cv::Exception&) {
      return {};
    }
    return image;
  }

  fs::path path_;
  std::string kind_ = kVideoKind;
  std::string name_;
  std::optional<Camera> camera_;
  cv::VideoCapture capture_;
  cv::Size size_;
  int frames_ = 0;  // by the header
  int size_estimate_ = 0;
  int next_;
  int every_;
  int last_;
  int grabbed_ = -1;  // number of the frame that can be retrieved
};

}  // namespace

std::unique_ptr<Source> OpenVideo(const fs::path& path, const SourceOptions& options) {
  return std::make_unique<VideoSource>(path, options);
}

}  // namespace waystone
