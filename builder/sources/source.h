// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/camera/camera.h"

namespace waystone {

// One frame of a sequence, as named by its source, before it is decoded.
struct FrameInfo {
  int number = 0;      // in the source, from 0 (before --every and --from/--to leave any out)
  std::string source;  // name relative to the source: "rgb/000120.jpg", "frame 120"
  std::optional<double> time_s;
};

struct Frame {
  FrameInfo info;
  cv::Mat grey;   // CV_8UC1; empty when the frame can't be decoded
  std::string error;  // then: why, in one line
};

// Which part of a source is used.
struct SourceOptions {
  int every = 1;             // take every n-th frame
  int from = 0;              // first frame number
  std::optional<int> to;     // last frame number, inclusive; the end when absent
  std::optional<std::filesystem::path> camera_file;  // OpenCV, ROS, Kalibr or COLMAP; wins over
                                                     // what the source itself brings

  void Check() const;  // throws MapError(kBadOptions)
};

// A sequence of images in order: a folder, a glob, a video, TUM RGB-D, KITTI odometry, EuRoC.
// Sequential: Next() gives frame after frame. Not thread-safe.
class Source {
 public:
  virtual ~Source() = default;

  virtual const std::string& kind() const = 0;   // "folder", "video", "tum", "kitti", "euroc"
  virtual const std::string& name() const = 0;   // of the folder or file, without its path
  virtual int size() const = 0;                  // frames that Next() will give (an estimate for
                                                 // videos whose header doesn't know)
  virtual const std::optional<Camera>& camera() const = 0;
  // "TUM sequence, 1000 frames 640x480": what was recognised.
  virtual std::string Announcement() const = 0;

  // The next frame, or nothing at the end. A frame that can't be decoded comes with its error; it
  // is never fatal. Frames of another size than the first come with an error too.
  virtual std::optional<Frame> Next() = 0;
};

// Recognises what `path` is and opens it. Throws MapError(kBadSource) when it is nothing we know or
// holds no image, with what was found there and what to do; kBadCamera for a camera file.
std::unique_ptr<Source> OpenSource(const std::string& path, const SourceOptions& options);

// Reads one camera file, recognising OpenCV YAML/XML-free YAML, ROS camera_info, Kalibr camchain,
// COLMAP cameras.txt and our own `camera_model:` YAML by their keys. Throws MapError(kBadCamera).
Camera ReadCameraFile(const std::filesystem::path& path);

}  // namespace waystone
