// SPDX-License-Identifier: Apache-2.0
#include "cli/files/given_poses.h"

#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "cli/files/image_poses.h"
#include "core/base/error.h"
#include "core/base/text.h"

namespace waystone {
namespace {

LengthUnit UnitByName(const std::string& name) {
  for (const LengthUnit unit : {LengthUnit::kUnknown, LengthUnit::kMetres}) {
    if (name == NameOf(unit)) return unit;
  }
  throw MapError(ErrorCode::kUsage, "unit is " + name + "; it must be metres or unknown");
}

Eigen::Isometry3d ParseTransform(const std::string& text) {
  constexpr size_t kNumbers = 7;
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  if (text.empty()) return transform;
  std::vector<double> numbers;
  for (const std::string& word : Words(text, " \t,")) {
    const auto number = ToNumber(word);
    if (number && std::isfinite(*number)) numbers.push_back(*number);
  }
  const bool complete = numbers.size() == kNumbers && Words(text, " \t,").size() == kNumbers;
  if (complete) {
    const Eigen::Quaterniond q(numbers[6], numbers[3], numbers[4], numbers[5]);
    constexpr double kAboutUnit = 0.01;
    if (std::abs(q.norm() - 1) <= kAboutUnit) {
      transform.translation() = Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
      transform.linear() = q.normalized().toRotationMatrix();
      return transform;
    }
  }
  throw MapError(ErrorCode::kUsage, "body-from-camera is '" + Printable(text) +
                                        "'; it must be seven numbers x y z qx qy qz qw with a "
                                        "quaternion of length 1");
}

// The pose of an image that the user names as the poses do: by name, time or number.
Eigen::Vector3d FindPosition(const ImagePoses& images, const std::string& image,
                             const std::string& file) {
  const std::optional<int64_t> whole = ToInteger(image);
  const bool is_frame = whole && std::in_range<int>(*whole);
  const auto number = is_frame ? std::optional(static_cast<int>(*whole)) : std::nullopt;
  const auto pose = images.Find(image, ToNumber(image), number);
  if (pose) return pose->world_from_camera.translation();
  throw MapError(ErrorCode::kBadRequest,
                 "--scale-by: " + file + " has no pose of '" + Printable(image) +
                     "'; name two images as the poses do (by name, time or number)");
}

double DistanceOf(const PoseFlags& flags) {
  const auto metres = ToNumber(flags.scale_by.at(2));
  if (metres && *metres > 0 && std::isfinite(*metres)) return *metres;
  throw MapError(ErrorCode::kUsage, "--scale-by: '" + Printable(flags.scale_by[2]) +
                                        "' is not a distance in metres above 0");
}

// The factor of the positions that gives two of them a known distance.
double FindScale(const ImagePoses& images, const PoseFlags& flags) {
  if (flags.scale_by.empty()) return 1;
  const double metres = DistanceOf(flags);
  const double distance = (FindPosition(images, flags.scale_by[0], flags.file) -
                           FindPosition(images, flags.scale_by[1], flags.file))
                              .norm();
  if (distance > 0) return metres / distance;
  throw MapError(ErrorCode::kBadRequest, "--scale-by: the poses of '" +
                                             Printable(flags.scale_by[0]) + "' and '" +
                                             Printable(flags.scale_by[1]) +
                                             "' are at one position; name two that are far apart");
}

}  // namespace

void CheckPoseFlags(const PoseFlags& flags) {
  UnitByName(flags.unit);
  ParseTransform(flags.body_from_camera);
  if (flags.scale_by.empty()) return;
  DistanceOf(flags);
  if (UnitByName(flags.unit) == LengthUnit::kMetres) {
    throw MapError(
        ErrorCode::kUsage,
        "--scale-by scales poses of unknown unit, but --unit is metres; leave out one of "
        "them");
  }
}

GivenPoses ReadGivenPoses(const PoseFlags& flags, int sources) {
  CheckPoseFlags(flags);
  std::vector<FilePose> poses = ReadPoseFile(flags.file);
  for (const FilePose& pose : poses) {
    if (pose.pose.has_rotation) continue;
    throw MapError(ErrorCode::kBadRequest,
                   flags.file +
                       " has positions without orientations; add the columns qx, qy, qz, "
                       "qw");
  }
  const auto images = std::make_shared<const ImagePoses>(std::move(poses), flags.max_gap_s);
  if (images->AreNumbered() && sources > 1) {
    throw MapError(ErrorCode::kBadRequest,
                   flags.file + " numbers its poses, which doesn't tell the frames of " +
                       std::to_string(sources) + " sources apart; give poses with names or times");
  }
  GivenPoses given;
  given.frame = flags.frame;
  given.unit = flags.scale_by.empty() ? UnitByName(flags.unit) : LengthUnit::kMetres;
  const double scale = FindScale(*images, flags);
  const Eigen::Isometry3d body_from_camera = ParseTransform(flags.body_from_camera);
  given.of_image = [images, body_from_camera, scale](
                       const Sequence& sequence,
                       const FrameInfo& image) -> std::optional<Eigen::Isometry3d> {
    const auto pose = images->Find(sequence.name + "/" + image.source, image.time_s, image.number);
    if (!pose) return std::nullopt;
    Eigen::Isometry3d world_from_body = pose->world_from_camera;
    world_from_body.translation() *= scale;
    return world_from_body * body_from_camera;
  };
  return given;
}

}  // namespace waystone
