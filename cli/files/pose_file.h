// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/files/csv_file.h"
#include "quality/pose_error.h"

namespace waystone {

// A pose from a file, and what tells which image it belongs to: its name, its frame number, its
// time stamp or, without any, its place in the file.
struct FilePose {
  std::string name;
  std::optional<double> time_s;
  int number = 0;
  TruePose pose;
  bool has_frame = false;  // `number` is a frame number that the file gives beside a time stamp
};

// Whether a file may have this pose: finite, with no coordinate beyond 1e12, in any unit. Pure;
// thread-safe.
bool IsPose(const TruePose& pose);

// The columns x, y, z of a CSV file and, where all four are there, qw, qx, qy, qz.
class PoseColumns {
 public:
  // Nothing where the header has none of the first three; fails where it has only some of them.
  static std::optional<PoseColumns> Find(const CsvFile& file);
  // Nothing for a row without a position. Fails for what isn't a number.
  std::optional<TruePose> Read(const CsvFile& file, const CsvFile::Row& row) const;

 private:
  std::array<size_t, 3> position_{};
  std::optional<std::array<size_t, 4>> rotation_;
};

// Reads poses of images, recognised by extension and content:
//   .csv           columns x, y, z, optionally qx, qy, qz, qw, and one of image, keyframe, id,
//                  frame or time_s; or EuRoC's ground truth ("#timestamp" in ns, p_x, p_y, p_z,
//                  q_w, q_x, q_y, q_z, of the body); or odometry as nav_msgs/Odometry (columns that
//                  end in pose.pose.position.x and so on, and header.stamp, or its seconds and
//                  nanoseconds), also as `ros2 topic echo --csv` prints it, without a header
//   .bin           COLMAP's images.bin
//   TUM            "time x y z qx qy qz qw" per line
//   KITTI          12 numbers per line, 3x4 by rows
//   COLMAP         images.txt
//   g2o            VERTEX_SE3:QUAT lines, whose ids are frame numbers
// All are world_from_camera but COLMAP's, which are inverted. Throws MapError: kFileUnreadable;
// kBadRequest naming the line.
std::vector<FilePose> ReadPoseFile(const std::filesystem::path& path);

}  // namespace waystone
