// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "cli/files/pose_file.h"

namespace waystone {

// Poses by the images that they are of. Immutable; thread-safe.
class ImagePoses {
 public:
  // A pose is interpolated between poses whose time stamps are at most `max_gap_s` apart.
  explicit ImagePoses(std::vector<FilePose> poses, double max_gap_s = 0.2);
  ImagePoses(const ImagePoses&) = delete;
  ImagePoses& operator=(const ImagePoses&) = delete;

  // By name (also without its folders or its extension) where the poses have names; else by number
  // where the file gives frame numbers; else by time stamp, else by the pose's place in the file.
  // Where none can be interpolated, a pose within 20 ms is taken. Nothing where none matches.
  std::optional<TruePose> Find(const std::string& name, const std::optional<double>& time_s,
                               const std::optional<int>& number) const;

  bool AreNamed() const { return !by_name_.empty(); }
  // Whether the poses have frame numbers, or neither names nor time stamps.
  bool AreNumbered() const { return by_name_.empty() && (have_frames_ || by_time_.empty()); }

 private:
  const TruePose* FindNamed(const std::string& name) const;
  std::optional<TruePose> FindTimed(double time_s) const;

  std::vector<FilePose> poses_;
  double max_gap_s_;
  bool have_frames_ = false;                                  // frame numbers go before time stamps
  std::unordered_map<std::string, const TruePose*> by_name_;  // into poses_, as the following
  std::unordered_map<int, const TruePose*> by_number_;
  std::vector<const FilePose*> by_time_;  // ascending
};

}  // namespace waystone
