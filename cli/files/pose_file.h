// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "cli/files/csv_file.h"
#include "quality/pose_error.h"

namespace waystone {

// A pose of a file and what says which image it belongs to: its name, its time stamp or, without
// either, its number in the sequence.
struct FilePose {
  std::string name;
  std::optional<double> time_s;
  int number = 0;
  TruePose pose;
};

// The columns x, y, z of a CSV file and, where all four are there, qw, qx, qy, qz.
class PoseColumns {
 public:
  // Nothing where the header has none of the first three; fails where it has a part of them.
  static std::optional<PoseColumns> Find(const CsvFile& file);
  // Nothing for a row without a position. Fails for what isn't a number.
  std::optional<TruePose> Read(const CsvFile& file, const CsvFile::Row& row) const;

 private:
  std::array<size_t, 3> position_{};
  std::optional<std::array<size_t, 4>> rotation_;
};

// Reads poses of images: a CSV file (by its extension) with the columns x, y, z, optionally qx, qy,
// qz, qw, and one of image, keyframe, id, frame or time_s; a TUM trajectory ("time x y z qx qy qz
// qw"); KITTI poses (12 numbers a line, 3x4 by rows); or COLMAP's images.txt. All are
// world_from_camera but COLMAP's. Throws MapError: kFileUnreadable; kBadRequest naming the line.
std::vector<FilePose> ReadPoseFile(const std::filesystem::path& path);

// The poses by the image that they are of.
class ImagePoses {
 public:
  explicit ImagePoses(std::vector<FilePose> poses);
  ImagePoses(const ImagePoses&) = delete;
  ImagePoses& operator=(const ImagePoses&) = delete;

  // By name (also without its folders or its extension), else by time stamp, to 20 ms, else by
  // number, where the poses have no names or stamps. Nothing where none fits.
  const TruePose* Find(const std::string& name, const std::optional<double>& time_s,
                       int number) const;

 private:
  const TruePose* FindNamed(const std::string& name) const;

  std::vector<FilePose> poses_;
  std::unordered_map<std::string, const TruePose*> by_name_;  // into poses_
};

}  // namespace waystone
