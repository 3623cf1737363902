// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <cmath>

#include "builder/sources/camera_section.h"
#include "builder/sources/colmap_camera.h"
#include "builder/sources/rig_source.h"
#include "builder/sources/source.h"

namespace waystone {
namespace {

namespace fs = std::filesystem;

// How far a written rotation may be from a true one: files have few digits.
constexpr double kMaxRotationError = 1e-3;

Eigen::Isometry3d Pose(const CameraSection& file, const Eigen::Matrix3d& rotation,
                       const Eigen::Vector3d& translation, const std::string& key) {
  const bool sound = rotation.allFinite() && rotation.determinant() > 0 &&
                     (rotation.transpose() * rotation).isIdentity(kMaxRotationError);
  if (!sound) file.Refuse(key + " must be a rotation");
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::Quaterniond(rotation).normalized().toRotationMatrix();
  pose.translation() = translation;
  return pose;
}

// x_cn = T x_cn-1, four rows of four.
Eigen::Isometry3d ReadChainLink(const CameraSection& file) {
  constexpr const char* kKey = "T_cn_cnm1";
  const std::vector<std::vector<double>> rows = file.Rows(kKey, 4, 4);
  Eigen::Matrix3d rotation;
  Eigen::Vector3d translation;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) rotation(i, j) = rows[i][j];
    translation[i] = rows[i][3];
  }
  return Pose(file, rotation, translation, kKey);
}

Rig ReadCamchain(const CameraSection& file) {
  Rig rig;
  const int count = file.CountPrefixed("cam");
  for (int i = 0; i < count; ++i) {
    const std::string name = "cam" + std::to_string(i);
    const CameraSection section = file.Under(name);  // refuses a gap in the numbers
    RigCamera camera{.name = name, .camera = ReadCameraSection(section)};
    if (i > 0) {
      camera.rig_from_camera =
          rig.cameras.back().rig_from_camera * ReadChainLink(section).inverse();
    }
    rig.cameras.push_back(camera);
  }
  return rig;
}

RigCamera ReadOwnRigCamera(const CameraSection& section) {
  constexpr const char* kRotation = "rig_from_camera_xyzw";
  constexpr const char* kTranslation = "rig_from_camera_m";
  RigCamera camera{.name = section.Text("name"), .camera = ReadCameraSection(section)};
  if (camera.name.empty()) section.Refuse("a camera has no name; name it after its images");
  const std::vector<double> q = section.Numbers({kRotation}, 4);
  const Eigen::Quaterniond quaternion(q[3], q[0], q[1], q[2]);
  if (!(std::abs(quaternion.norm() - 1) < kMaxRotationError)) {
    section.Refuse(std::string(kRotation) + " has length " + std::to_string(quaternion.norm()) +
                   "; it must be a unit quaternion x y z w");
  }
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
  if (section.Has({kTranslation})) {
    const std::vector<double> numbers = section.Numbers({kTranslation}, 3);
    t = {numbers[0], numbers[1], numbers[2]};
  }
  camera.rig_from_camera = Pose(section, quaternion.normalized().toRotationMatrix(), t, kRotation);
  return camera;
}

Rig ReadYamlRig(const fs::path& path) {
  const CameraSection file = OpenCameraYaml(path);
  if (file.Has({"cam0"}) || file.Has({"cam1"})) return ReadCamchain(file);
  if (!file.Has({"cameras"})) return RigOfOne(ReadCameraSection(file));
  Rig rig;
  for (const CameraSection& section : file.List("cameras")) {
    rig.cameras.push_back(ReadOwnRigCamera(section));
  }
  return rig;
}

}  // namespace

bool HasSeveralCameras(const fs::path& path) {
  if (LooksLikeColmap(path)) return false;
  const CameraSection file = OpenCameraYaml(path);
  return file.Has({"cam1"}) || file.Has({"cameras"});
}

Rig ReadRigFile(const fs::path& path) {
  Rig rig = LooksLikeColmap(path) ? RigOfOne(ReadColmapCamera(path)) : ReadYamlRig(path);
  try {
    CheckRig(rig);
  } catch (const MapError& error) {
    throw MapError(ErrorCode::kBadCamera, Quoted(path) + ": " + error.what());
  }
  return rig;
}

}  // namespace waystone
