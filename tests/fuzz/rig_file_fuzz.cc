// SPDX-License-Identifier: Apache-2.0
#include "builder/sources/rig_source.h"
#include "tests/fuzz/camera_yaml.h"
#include "tests/fuzz/fuzz_targets.h"

namespace waystone {
namespace {

// Cameras are called cam0, cam1, ...: a name may be any text.
std::string RigYaml(const Rig& rig) {
  std::string yaml = "cameras:\n";
  for (size_t i = 0; i < rig.cameras.size(); ++i) {
    const Eigen::Isometry3d& pose = rig.cameras[i].rig_from_camera;
    const Eigen::Quaterniond q(pose.linear());
    const Eigen::Vector3d t = pose.translation();
    yaml += "  - name: cam" + std::to_string(i) + "\n" + CameraYaml(rig.cameras[i].camera, "    ") +
            "    rig_from_camera_xyzw: [" + ExactText(q.x()) + ", " + ExactText(q.y()) + ", " +
            ExactText(q.z()) + ", " + ExactText(q.w()) + "]\n    rig_from_camera_m: [" +
            ExactText(t.x()) + ", " + ExactText(t.y()) + ", " + ExactText(t.z()) + "]\n";
  }
  return yaml;
}

void CheckPose(const Eigen::Isometry3d& pose) {
  Require(pose.matrix().allFinite(), "a camera's pose is finite");
  const Eigen::Matrix3d r = pose.linear();
  Require((r * r.transpose()).isIdentity(1e-9) && r.determinant() > 0, "a rotation is one");
}

}  // namespace

// A rig is sound, and written in our own format it is read to the same.
bool FuzzRigFile(FuzzInput input) {
  const auto path = WriteInput("rig.yaml", TextOf(input));
  ReadOrRefuse([&] { return HasSeveralCameras(path); });
  const auto rig = ReadOrRefuse([&] { return ReadRigFile(path); });
  if (!rig) return false;
  for (const RigCamera& camera : rig->cameras) CheckPose(camera.rig_from_camera);
  const auto written = WriteInput("written.yaml", RigYaml(*rig));
  const Rig again = ReadBack([&] { return ReadRigFile(written); }, "a rig");
  Require(again.cameras.size() == rig->cameras.size(), "a rig keeps its cameras");
  for (size_t i = 0; i < rig->cameras.size(); ++i) {
    const RigCamera& a = rig->cameras[i];
    const RigCamera& b = again.cameras[i];
    Require(a.camera == b.camera, "a rig's camera is written and read to the same");
    Require(a.rig_from_camera.translation() == b.rig_from_camera.translation() &&
                a.rig_from_camera.linear().isApprox(b.rig_from_camera.linear(), 1e-9),
            "a rig camera's pose is written and read to the same");
  }
  return true;
}

}  // namespace waystone
