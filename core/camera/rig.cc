// SPDX-License-Identifier: Apache-2.0
#include "core/camera/rig.h"

#include <Eigen/LU>
#include <set>

#include "core/base/error.h"

namespace waystone {
namespace {

constexpr size_t kMaxCameras = 64;
constexpr int kMaxFaceWidth = 8192;  // px
constexpr double kMaxSkew = 1e-6;    // of a rotation matrix, entry by entry

[[noreturn]] void RefuseRig(const std::string& cause) {
  throw MapError(ErrorCode::kBadCamera, cause);
}

bool IsRotation(const Eigen::Matrix3d& r) {
  return r.allFinite() && (r.transpose() * r).isIdentity(kMaxSkew) && r.determinant() > 0;
}

// The camera looks along right x down.
RigCamera Face(const char* name, const Camera& camera, const Eigen::Vector3d& right,
               const Eigen::Vector3d& down) {
  RigCamera face{.name = name, .camera = camera};
  face.rig_from_camera.linear() << right, down, right.cross(down);
  return face;
}

}  // namespace

void CheckRig(const Rig& rig) {
  if (rig.cameras.empty() || rig.cameras.size() > kMaxCameras) {
    RefuseRig("a rig of " + std::to_string(rig.cameras.size()) +
              " cameras; the number must be between 1 and " + std::to_string(kMaxCameras));
  }
  std::set<std::string> names;
  for (const RigCamera& camera : rig.cameras) {
    const std::string name = "camera '" + camera.name + "'";
    if (!names.insert(camera.name).second)
      RefuseRig(name + " is duplicated; camera names must be unique");
    try {
      CheckCamera(camera.camera);
    } catch (const MapError& error) {
      RefuseRig(name + ": " + error.what());
    }
    if (!IsRotation(camera.rig_from_camera.linear()) ||
        !camera.rig_from_camera.translation().allFinite()) {
      RefuseRig(name + ": its pose in the rig must be a rotation and a finite translation");
    }
  }
}

void CheckImageSize(const RigCamera& camera, int width, int height) {
  const auto size = [](int w, int h) { return std::to_string(w) + "x" + std::to_string(h); };
  if (width == camera.camera.width && height == camera.camera.height) return;
  throw MapError(ErrorCode::kBadImage, "an image of " + size(width, height) +
                                           " pixels, but camera '" + camera.name + "' has " +
                                           size(camera.camera.width, camera.camera.height) +
                                           "; calibrate at the size of the images");
}

Rig RigOfOne(const Camera& camera) { return {.cameras = {{.name = "camera", .camera = camera}}}; }

Rig CubeRig(int width_px) {
  if (width_px < 1 || width_px > kMaxFaceWidth) {
    RefuseRig("faces " + std::to_string(width_px) + " px wide; the width must be between 1 and " +
              std::to_string(kMaxFaceWidth));
  }
  const double focal_px = 0.5 * width_px;
  const double middle_px = 0.5 * (width_px - 1);
  const Camera camera{.model = CameraModel::kPinhole,
                      .width = width_px,
                      .height = width_px,
                      .params = {focal_px, focal_px, middle_px, middle_px}};
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  const Eigen::Vector3d y = Eigen::Vector3d::UnitY();
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  return {.cameras = {Face("front", camera, x, y), Face("right", camera, -z, y),
                      Face("back", camera, -x, y), Face("left", camera, z, y),
                      Face("up", camera, x, z), Face("down", camera, x, -z)}};
}

}  // namespace waystone
