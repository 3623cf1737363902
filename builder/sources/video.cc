// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "builder/sources/edit_list.h"
#include "builder/sources/files.h"
#include "builder/sources/recognise.h"
#include "core/base/error.h"
#include "schema/sequence_kinds.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

// More than any video has; with as many left out, frame numbers still fit an int.
constexpr int kMostFrames = std::numeric_limits<int>::max() / 2;
// Bound on frames that are looked for or counted as lost one after the other: a header may say
// anything.
constexpr int kMostLost = 1'000'000;
constexpr double kSecondsPerMillisecond = 1e-3;
constexpr const char* kDamaged = "the frame can't be decoded; the video is damaged";

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

// FFmpeg shows text as pictures of it, and opens what playlists name.
bool IsText(const fs::path& path) {
  constexpr size_t kLooked = 512;
  std::string start(kLooked, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(start.data(), kLooked);
  start.resize(static_cast<size_t>(file.gcount()));
  if (start.empty() || start.starts_with("YUV4MPEG2")) return false;
  constexpr std::string_view kInText = "\t\n\v\f\r\x1b";
  return std::ranges::all_of(start, [&](char byte) {
    return static_cast<uint8_t>(byte) >= ' ' || kInText.find(byte) != std::string_view::npos;
  });
}

EncodedFrame Unreadable(FrameInfo info, std::string cause) {
  return {std::move(info),
          [cause = std::move(cause)]() -> cv::Mat { throw MapError(ErrorCode::kBadImage, cause); }};
}

// One decoder, front to back: a frame depends on those before it. Grabbing without retrieving skips
// the colour conversion, which is most of the cost of a skipped frame.
class VideoSource : public Source {
 public:
  VideoSource(const fs::path& path, const SourceOptions& options)
      : path_(path),
        name_(NameOfPath(path)),
        next_(options.from),
        every_(std::min(options.every, kMostFrames)),
        last_(std::min(options.to.value_or(kMostFrames), kMostFrames)) {
    Open(options.limits);
    if (!AdvanceTo(options.from)) {
      RefuseVideo(path, "it has " + std::to_string(number_ + 1) + " frames, none with index " +
                            std::to_string(options.from));
    }
    // The frame just reached proves that there are at least this many.
    frames_ = std::max(frames_, number_ + 1);
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

  // The header's frame count is often wrong, so the sequence ends when no more frames come, unless
  // that is clearly too early.
  std::optional<EncodedFrame> NextEncoded() override {
    if (next_ > last_ || !AdvanceTo(next_)) return std::nullopt;
    FrameInfo info{next_, "frame " + std::to_string(next_), std::nullopt};
    next_ += every_;
    if (!grabbed_) return Unreadable(std::move(info), CauseOfLoss());
    info.time_s = TimeOfGrabbed();
    cv::Mat image = Retrieve();
    return EncodedFrame(std::move(info), [image = std::move(image), size = size_] {
      if (image.size() != size) throw MapError(ErrorCode::kBadImage, kDamaged);
      return Grey(image);
    });
  }

 private:
  void Open(const DecodeLimits& limits) {
    if (IsText(path_)) RefuseVideo(path_, "it is a text file");
    try {
      capture_.open(path_.string(), cv::CAP_FFMPEG);
    } catch (const cv::Exception& error) {
      RefuseVideo(path_, error.err);
    }
    if (!capture_.isOpened()) RefuseVideo(path_, "FFmpeg finds no video stream");
    // As for images, pixels stay where the camera put them, which is what calibrations refer to.
    capture_.set(cv::CAP_PROP_ORIENTATION_AUTO, 0);
    size_ = {static_cast<int>(capture_.get(cv::CAP_PROP_FRAME_WIDTH)),
             static_cast<int>(capture_.get(cv::CAP_PROP_FRAME_HEIGHT))};
    CheckLimits({.format = "video", .width = size_.width, .height = size_.height}, limits);
    const double frames = capture_.get(cv::CAP_PROP_FRAME_COUNT);
    if (!(frames >= 1 && frames < kMostFrames)) return;
    announced_ = static_cast<int>(std::lround(frames * PlayedShare(path_)));
    frames_ = announced_;
  }

  // Moves on to a frame, which is grabbed or, where the video is damaged, lost. False at the end.
  bool AdvanceTo(int number) {
    while (number_ < number) {
      if (lost_ == 0 && !next_grabbed_) LookAhead();
      if (lost_ == 0 && !next_grabbed_) return false;
      grabbed_ = lost_ == 0;
      if (grabbed_) {
        next_grabbed_ = false;
      } else {
        --lost_;
      }
      ++number_;
    }
    return true;
  }

  // Grabs the next frame that can be decoded: FFmpeg fails once for each damaged one, and always
  // after the end.
  void LookAhead() {
    if (ended_) return;
    const int most = std::min(announced_ - (number_ + 1), kMostLost);
    int failed = 0;
    next_grabbed_ = capture_.grab();
    for (; !next_grabbed_ && failed < most; ++failed) next_grabbed_ = capture_.grab();
    if (next_grabbed_) {
      lost_ = failed;
      latest_s_ = std::max(latest_s_, capture_.get(cv::CAP_PROP_POS_MSEC) * kSecondsPerMillisecond);
    } else {
      ended_ = true;
      first_missing_ = number_ + 1;
      lost_ = CountMissing();
    }
  }

  // How many frames a video lacks that ends clearly before its header says. The number may be an
  // estimate from duration and rate, so time must be missing as well.
  int CountMissing() const {
    constexpr int kFewMissing = 2;
    constexpr double kFewMissingShare = 0.05;
    if (number_ < 0) return 0;  // nothing could be decoded: it is no video
    double missing = announced_ - (number_ + 1);
    if (latest_s_ > 0) {
      const double reached = std::round(latest_s_ * capture_.get(cv::CAP_PROP_FPS));
      missing = std::min(missing, announced_ - 1 - reached);
    }
    if (!(missing > kFewMissing && missing > kFewMissingShare * announced_)) return 0;
    return static_cast<int>(std::min<double>(missing, kMostLost));
  }

  std::string CauseOfLoss() const {
    if (!ended_ || number_ < first_missing_) return kDamaged;
    return "it is missing: the video ends after " + std::to_string(first_missing_) + " of the " +
           std::to_string(announced_) + " frames in its header, and is damaged or incomplete";
  }

  std::optional<double> TimeOfGrabbed() const {
    const double time_ms = capture_.get(cv::CAP_PROP_POS_MSEC);
    if (number_ > 0 && !(time_ms > 0)) return std::nullopt;  // a stream without time stamps
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
  int announced_ = 0;  // frames by the header; 0 where it doesn't say
  int frames_ = 0;     // the same, or as many as were found
  int size_estimate_ = 0;
  int next_;
  int every_;
  int last_;
  int number_ = -1;            // of the frame that was reached
  bool grabbed_ = false;       // whether it can be retrieved
  int lost_ = 0;               // frames after it that can't be decoded
  bool next_grabbed_ = false;  // whether the one after those was grabbed
  bool ended_ = false;
  int first_missing_ = 0;  // after the end
  double latest_s_ = 0;    // time of the latest frame that was grabbed
};

}  // namespace

std::unique_ptr<Source> OpenVideo(const fs::path& path, const SourceOptions& options) {
  return std::make_unique<VideoSource>(path, options);
}

}  // namespace waystone
