// SPDX-License-Identifier: Apache-2.0
#include "cli/files/image_poses.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

namespace waystone {
namespace {

constexpr double kSameTime_s = 0.02;

// Linear in position, at constant angular velocity in rotation.
TruePose InterpolatePose(const FilePose& before, const FilePose& after, double time_s) {
  const double span_s = *after.time_s - *before.time_s;
  const double share = span_s > 0 ? (time_s - *before.time_s) / span_s : 0;
  const Eigen::Isometry3d& a = before.pose.world_from_camera;
  const Eigen::Isometry3d& b = after.pose.world_from_camera;
  TruePose pose{Eigen::Isometry3d::Identity(), before.pose.has_rotation && after.pose.has_rotation};
  pose.world_from_camera.translation() = (1 - share) * a.translation() + share * b.translation();
  pose.world_from_camera.linear() = Eigen::Quaterniond(a.linear())
                                        .slerp(share, Eigen::Quaterniond(b.linear()))
                                        .normalized()
                                        .toRotationMatrix();
  return pose;
}

std::string WithoutExtension(const std::string& name) {
  return std::filesystem::path(name).replace_extension().string();
}

}  // namespace

ImagePoses::ImagePoses(std::vector<FilePose> poses, double max_gap_s)
    : poses_(std::move(poses)), max_gap_s_(max_gap_s) {
  for (const FilePose& pose : poses_) {
    if (!pose.name.empty()) by_name_.emplace(pose.name, &pose.pose);
    if (pose.time_s) by_time_.push_back(&pose);
    by_number_.emplace(pose.number, &pose.pose);
    have_frames_ = have_frames_ || pose.has_frame;
  }
  // Without extension, too, unless that is another one's name: a video's frames have none.
  for (const FilePose& pose : poses_) {
    if (!pose.name.empty()) by_name_.emplace(WithoutExtension(pose.name), &pose.pose);
  }
  std::ranges::stable_sort(by_time_, {}, [](const FilePose* pose) { return *pose->time_s; });
}

const TruePose* ImagePoses::FindNamed(const std::string& name) const {
  const auto find = [&](const std::string& part) -> const TruePose* {
    const auto found = by_name_.find(part);
    return found == by_name_.end() ? nullptr : found->second;
  };
  for (size_t from = 0; from != std::string::npos;) {  // with one folder fewer each time
    if (const TruePose* pose = find(name.substr(from))) return pose;
    const size_t slash = name.find('/', from);
    from = slash == std::string::npos ? slash : slash + 1;
  }
  return find(std::filesystem::path(name).stem().string());
}

std::optional<TruePose> ImagePoses::FindTimed(double time_s) const {
  const auto after = std::ranges::lower_bound(by_time_, time_s, {},
                                              [](const FilePose* pose) { return *pose->time_s; });
  const FilePose* next = after == by_time_.end() ? nullptr : *after;
  const FilePose* last = after == by_time_.begin() ? nullptr : *(after - 1);
  if (next && last && *next->time_s - *last->time_s <= max_gap_s_) {
    return InterpolatePose(*last, *next, time_s);
  }
  const auto distance = [&](const FilePose* pose) { return std::abs(*pose->time_s - time_s); };
  const FilePose* nearest = !last || (next && distance(next) < distance(last)) ? next : last;
  if (!nearest || distance(nearest) > kSameTime_s) return std::nullopt;
  return nearest->pose;
}

std::optional<TruePose> ImagePoses::Find(const std::string& name,
                                         const std::optional<double>& time_s,
                                         const std::optional<int>& number) const {
  if (!by_name_.empty()) {
    const TruePose* named = FindNamed(name);
    return named ? std::optional(*named) : std::nullopt;
  }
  const bool by_frame = have_frames_ && number;
  if (time_s && !by_time_.empty() && !by_frame) return FindTimed(*time_s);
  if (!number) return std::nullopt;
  const auto found = by_number_.find(*number);
  return found == by_number_.end() ? std::nullopt : std::optional(*found->second);
}

}  // namespace waystone
