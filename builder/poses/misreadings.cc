// SPDX-License-Identifier: Apache-2.0
#include "builder/poses/misreadings.h"

#include <array>
#include <cmath>

namespace waystone {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

struct Misreading {
  const char* text;
  Isometry3d (*corrected)(const Isometry3d&);
};

Isometry3d Invert(const Isometry3d& pose) { return pose.inverse(); }

Isometry3d WithOpenGlAxes(const Isometry3d& pose) {
  Isometry3d turned = pose;
  turned.linear() = pose.linear() * Vector3d(1, -1, -1).asDiagonal();
  return turned;
}

Isometry3d WithBodyAxes(const Isometry3d& pose) {
  Eigen::Matrix3d body_from_camera;  // body: x forward, y left, z up
  body_from_camera << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  Isometry3d turned = pose;
  turned.linear() = pose.linear() * body_from_camera;
  return turned;
}

// Which axis is negated makes no difference to the cameras' relative poses. The camera's x is
// negated as well, so that it is right-handed again and keeps its up and forward directions.
Isometry3d Mirror(const Isometry3d& pose) {
  const Vector3d axes(1, -1, 1);
  Isometry3d mirrored = pose;
  mirrored.linear() = axes.asDiagonal() * pose.linear() * Vector3d(-1, 1, 1).asDiagonal();
  mirrored.translation() = axes.asDiagonal() * pose.translation();
  return mirrored;
}

constexpr std::array<Misreading, 4> kMisreadings{{
    {"they fit as camera-from-world transforms; invert them", Invert},
    {"they fit with the camera's y up and z backward, as OpenGL has them; turn the camera's axes "
     "to x right, y down, z forward",
     WithOpenGlAxes},
    {"they fit as poses of a body with x forward, y left, z up; turn the axes to x right, y down, "
     "z forward",
     WithBodyAxes},
    {"they fit mirrored, as in a left-handed frame; negate one axis of the positions and turn the "
     "rotations accordingly",
     Mirror},
}};

}  // namespace

std::string RemedyFor(const std::function<double(const PoseReading&)>& share_of, double least) {
  std::string remedy;
  for (const Misreading& misreading : kMisreadings) {
    if (share_of(misreading.corrected) < least) continue;
    remedy += (remedy.empty() ? "" : "; or ") + std::string(misreading.text);
  }
  if (!remedy.empty()) return remedy;
  return "check that they are of this sequence, that times and names match, and that the "
         "calibration is right";
}

std::string SharePercent(double share) { return std::to_string(std::lround(100 * share)) + "%"; }

}  // namespace waystone
