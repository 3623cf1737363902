// SPDX-License-Identifier: Apache-2.0
#include "cli/files/pose_file.h"

#include "cli/files/trajectory_file.h"
#include "tests/fuzz/camera_yaml.h"
#include "tests/fuzz/fuzz_targets.h"

namespace waystone {
namespace {

void CheckFilePose(const FilePose& pose) {
  const Eigen::Isometry3d& world_from_camera = pose.pose.world_from_camera;
  Require(world_from_camera.matrix().allFinite(), "a pose is finite");
  const Eigen::Matrix3d r = world_from_camera.linear();
  Require((r * r.transpose()).isIdentity(1e-9), "a pose's rotation is one");
}

// As a TUM trajectory, with numbers for time stamps.
std::string TumText(const std::vector<FilePose>& poses) {
  std::string text;
  for (const FilePose& pose : poses) {
    const Eigen::Isometry3d& at = pose.pose.world_from_camera;
    const Eigen::Quaterniond q(at.linear());
    text += std::to_string(pose.number);
    for (const double number : {at.translation().x(), at.translation().y(), at.translation().z(),
                                q.x(), q.y(), q.z(), q.w()}) {
      text += " " + ExactText(number);
    }
    text += "\n";
  }
  return text;
}

void CheckTrajectory(const std::filesystem::path& path) {
  const auto trajectory = ReadOrRefuse([&] { return ReadTrajectory(path); });
  if (!trajectory) return;
  Require(trajectory->times_s.empty() || trajectory->times_s.size() == trajectory->poses.size(),
          "a time for each pose");
  for (const Pose2& pose : trajectory->poses) {
    Require(std::isfinite(pose.x) && std::isfinite(pose.y) && std::isfinite(pose.theta_rad),
            "a trajectory is finite");
  }
}

}  // namespace

// The input's first byte says whether it is a CSV file ('c') or COLMAP's images.bin ('b'). Poses
// are finite, and written as a TUM trajectory they are read to the same.
bool FuzzPoseFile(FuzzInput input) {
  if (input.empty()) return false;
  const char* const name =
      input[0] == 'c' ? "poses.csv" : (input[0] == 'b' ? "images.bin" : "poses.txt");
  const auto path = WriteInput(name, TextOf(input.subspan(1)));
  CheckTrajectory(path);
  const auto poses = ReadOrRefuse([&] { return ReadPoseFile(path); });
  if (!poses) return false;
  Require(!poses->empty(), "a file has poses, or is refused");
  for (const FilePose& pose : *poses) CheckFilePose(pose);
  const auto written = WriteInput("written.txt", TumText(*poses));
  const auto again = ReadBack([&] { return ReadPoseFile(written); }, "a trajectory");
  Require(again.size() == poses->size(), "a trajectory keeps its poses");
  for (size_t i = 0; i < again.size(); ++i) {
    const Eigen::Isometry3d& a = (*poses)[i].pose.world_from_camera;
    const Eigen::Isometry3d& b = again[i].pose.world_from_camera;
    Require(a.translation() == b.translation() && a.linear().isApprox(b.linear(), 1e-9),
            "a pose is written and read to the same");
  }
  return true;
}

}  // namespace waystone
