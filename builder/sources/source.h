// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/options.h"
#include "core/camera/camera.h"
#include "core/camera/rig.h"
#include "core/image/decode.h"

namespace waystone {

// One frame of a sequence, as named by its source, before it is decoded.
struct FrameInfo {
  int number = 0;      // in the source, from 0 (before --every and --from/--to leave any out)
  std::string source;  // name relative to the source: "rgb/000120.jpg", "frame 120"
  std::optional<double> time_s;
};

struct Frame {
  FrameInfo info;
  // CV_8UC1: one per camera of Source::faces(), or the frame itself. Empty when one of them can't
  // be decoded.
  std::vector<cv::Mat> images;
  cv::Mat grey;       // CV_8UC1: the images joined; empty when that isn't possible
  std::string error;  // then: why, in one line
};

// A frame that is listed but not decoded yet: NextEncoded() returns these one after the other, and
// worker threads decode them. A frame of a file holds only the path (reading is part of Decode); a
// frame of a video holds its colours, since a video is decoded in order. Copies are cheap and share
// what they hold; it may outlive its Source.
class EncodedFrame {
 public:
  // `load` gives a CV_8UC1 image or throws MapError; it may be called from any thread.
  EncodedFrame(FrameInfo info, std::function<cv::Mat()> load);
  // A frame that is joined from the images of a rig's cameras (Source::faces()): `load` returns
  // them, one per camera.
  EncodedFrame(FrameInfo info, std::function<std::vector<cv::Mat>()> load,
               std::function<cv::Mat(const std::vector<cv::Mat>&)> join);

  const FrameInfo& info() const { return info_; }
  // The images of which the frame consists: one per camera of Source::faces(), or the frame itself.
  // Any thread. Throws MapError for one that can't be read.
  std::vector<cv::Mat> Load() const { return load_(); }
  // Joins these images into the frame (CV_8UC1). Any thread. Throws MapError.
  cv::Mat Join(const std::vector<cv::Mat>& images) const { return join_(images); }
  // Loads and joins; without `join` Frame::grey stays empty. Any thread, any number of times. A
  // frame that can't be decoded, is missing, or differs in size from the first one is returned with
  // its error; nothing is thrown for it.
  Frame Decode(bool join = true) const;

 private:
  FrameInfo info_;
  std::function<std::vector<cv::Mat>()> load_;
  std::function<cv::Mat(const std::vector<cv::Mat>&)> join_;
};

// Which part of a source is used, and how.
struct SourceOptions {
  int every = 1;
  int from = 0;
  // Last frame number, inclusive, `from` or more; the end when absent.
  std::optional<int> to = std::nullopt;
  // OpenCV, ROS, Kalibr, COLMAP or our own (ReadCameraFile), or a rig's (ReadRigFile); wins over
  // what the source brings.
  std::optional<std::filesystem::path> camera_file = std::nullopt;
  DecodeLimits limits = {};  // of each frame

  static constexpr int kUnlistedMembers = 2;  // to and camera_file, which are there or not
  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"every", &SourceOptions::every, AtLeast(1), "frames",
                    "Take every n-th frame, counted from `from`."},
        OptionField{"from", &SourceOptions::from, AtLeast(0), "", "Number of the first frame."},
        OptionGroup{"limits", &SourceOptions::limits});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// A sequence of images in order: a folder, a glob, a video, TUM RGB-D, KITTI odometry, EuRoC, the
// panoramas of a rig.
// Sequential: NextEncoded() returns frame after frame. Not thread-safe; the frames that it returns
// are.
class Source {
 public:
  virtual ~Source() = default;

  virtual const std::string& kind() const = 0;  // one of kSequenceKinds
  virtual const std::string& name() const = 0;  // of the folder or file, without its path
  virtual int size() const = 0;                 // frames that NextEncoded() will give (an estimate
                                                // for videos, whose headers may be wrong)
  // For images of the size of the source's frames.
  virtual const std::optional<Camera>& camera() const = 0;
  // Of the source's frames, px; 0 by 0 where it isn't known without decoding one.
  virtual cv::Size frame_size() const { return {}; }
  // The cameras of a rig: frames are joined from their images, or are those of the first one (kind
  // "cameras"); nothing for a source without a rig.
  virtual std::optional<Rig> faces() const { return std::nullopt; }
  // "TUM sequence, 1000 frames 640x480": what was recognised; followed by ", 100 used" when options
  // leave some out.
  virtual std::string Announcement() const = 0;

  // The next frame, or nothing at the end. Cheap for files; for a video this is where it is
  // decoded.
  virtual std::optional<EncodedFrame> NextEncoded() = 0;

  // The next frame, decoded, or nothing at the end: for callers that can wait.
  std::optional<Frame> Next();
};

// Recognises what `path` is and opens it:
//   a folder with rgb.txt                      TUM RGB-D; camera.yaml beside it
//   a folder with image_0/ or image_2/ and     KITTI odometry; the camera is P0 or P2 of calib.txt
//     times.txt or calib.txt
//   a folder with mav0/cam0/data.csv           EuRoC (also its mav0 or cam0); cam0/sensor.yaml
//   a folder with front, right, back, left     the panoramas of a rig of 90 degree faces (perhaps
//     (a folder each, or in numbered folders)    up and down too)
//   a folder with rig.yaml in or beside it     a calibrated rig; frames are its first camera's, and
//     (or options.camera_file) and a folder      the orientation layer looks at all
//     or file called like each camera
//   a folder with images                       in natural order (img2 before img10); camera.yaml in
//                                              it, or beside it when it is called images
//   a folder with images/                      the same
//   a pattern such as walk/*.jpg               the images that match, in natural order
//   a video                                    whatever FFmpeg opens; not turned upright
// Throws MapError: kBadOptions; kBadSource when `path` is none of these or no frame of it can be
// read, with what was found there and what to do; kBadCamera for a camera file that can't be read
// or is for images of another size; kFileUnreadable for a folder without permission. Thread-safe,
// except for patterns (glob(3) isn't).
std::unique_ptr<Source> OpenSource(const std::string& path, const SourceOptions& options);

// Reads one camera file, recognising by their keys: OpenCV's YAML (`camera_matrix`), ROS
// camera_info (the file or a dumped message), Kalibr's camchain (its cam0), EuRoC's sensor.yaml,
// COLMAP's cameras.txt or cameras.bin (with one camera) and our own:
//   camera_model: OPENCV           # a name of COLMAP's, see core/camera/camera.h
//   image_width: 640
//   image_height: 480
//   fx: 515.0                      # and so on: the model's parameters by name
// Throws MapError(kBadCamera) with the file, the key or line, and what to do. Thread-safe.
Camera ReadCameraFile(const std::filesystem::path& path);

}  // namespace waystone
