// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/align_frames.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "core/geometry/rotation.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr size_t kMaxCameras = 80;  // each pair of which is tried
constexpr size_t kFewest = 3;
constexpr double kMaxAngle_rad = 0.05;
constexpr double kMaxSigmas = 4;
// How much two frames of one building differ beyond the stated errors, as a share of the cameras'
// extent: poses of other programs drift.
constexpr double kDrift = 0.02;

std::vector<CameraInFrames> SpreadOver(const std::vector<CameraInFrames>& cameras) {
  if (cameras.size() <= kMaxCameras) return cameras;
  std::vector<CameraInFrames> chosen;
  for (size_t i = 0; i < kMaxCameras; ++i) {
    chosen.push_back(cameras[i * cameras.size() / kMaxCameras]);
  }
  return chosen;
}

class Aligner {
 public:
  Aligner(std::vector<CameraInFrames> cameras, bool same_unit)
      : cameras_(std::move(cameras)), same_unit_(same_unit) {
    Vector3d low = cameras_.front().to_from_camera.translation();
    Vector3d high = low;
    for (const CameraInFrames& camera : cameras_) {
      low = low.cwiseMin(camera.to_from_camera.translation());
      high = high.cwiseMax(camera.to_from_camera.translation());
    }
    drift_ = kDrift * (high - low).norm();
  }

  std::optional<FrameChange> Find() {
    for (size_t i = 0; i < cameras_.size(); ++i) {
      if (same_unit_) Try(i, 1);
      for (size_t j = 0; !same_unit_ && j < cameras_.size(); ++j) {
        if (j != i) TryPair(i, j);
      }
    }
    if (best_.size() < std::max(kFewest, (cameras_.size() + 1) / 2)) return std::nullopt;
    return Fit();
  }

 private:
  // In the unit of `to`; `scale` of these are one unit of `from`.
  double Tolerance(const CameraInFrames& camera, double scale) const {
    const double unit = camera.answered_in_from ? scale : 1;
    return kMaxSigmas * unit * camera.position_sigma + drift_;
  }

  Matrix3d RotationBy(const CameraInFrames& camera) const {
    return camera.to_from_camera.linear() * camera.from_from_camera.linear().transpose();
  }

  void TryPair(size_t i, size_t j) {
    const auto distance = [&](auto frame) {
      return ((cameras_[i].*frame).translation() - (cameras_[j].*frame).translation()).norm();
    };
    const double in_to = distance(&CameraInFrames::to_from_camera);
    const double in_from = distance(&CameraInFrames::from_from_camera);
    if (!(in_from > 0)) return;
    const double scale = in_to / in_from;
    // Cameras nearer to each other than their errors say nothing about the scale.
    if (in_to >= 2 * Tolerance(cameras_[i], scale)) Try(i, scale);
  }

  void Try(size_t i, double scale) {
    const Matrix3d rotation = RotationBy(cameras_[i]);
    const Vector3d translation = cameras_[i].to_from_camera.translation() -
                                 scale * rotation * cameras_[i].from_from_camera.translation();
    std::vector<size_t> agreeing;
    for (size_t k = 0; k < cameras_.size(); ++k) {
      const CameraInFrames& camera = cameras_[k];
      const Vector3d at = scale * rotation * camera.from_from_camera.translation() + translation;
      if ((at - camera.to_from_camera.translation()).norm() > Tolerance(camera, scale)) continue;
      if (RotationAngle(RotationBy(camera), rotation) > kMaxAngle_rad) continue;
      agreeing.push_back(k);
    }
    if (agreeing.size() > best_.size()) best_ = std::move(agreeing);
  }

  // Least squares: the mean of the rotations, then scale and translation of the positions.
  std::optional<FrameChange> Fit() const {
    FrameChange change;
    change.cameras = static_cast<int>(best_.size());
    const auto count = static_cast<double>(best_.size());
    Matrix3d sum = Matrix3d::Zero();
    Vector3d middle_to = Vector3d::Zero();
    Vector3d middle_from = Vector3d::Zero();
    for (const size_t i : best_) {
      sum += RotationBy(cameras_[i]);
      middle_to += cameras_[i].to_from_camera.translation() / count;
      middle_from += cameras_[i].from_from_camera.translation() / count;
    }
    const Eigen::JacobiSVD<Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
    change.rotation = svd.matrixU() * svd.matrixV().transpose();  // near the mean: no reflection
    if (!same_unit_) {
      double along = 0;
      double length = 0;
      for (const size_t i : best_) {
        const Vector3d from =
            change.rotation * (cameras_[i].from_from_camera.translation() - middle_from);
        along += from.dot(cameras_[i].to_from_camera.translation() - middle_to);
        length += from.squaredNorm();
      }
      if (!(along > 0)) return std::nullopt;
      change.scale = along / length;
    }
    change.translation = middle_to - change.scale * change.rotation * middle_from;
    return change;
  }

  std::vector<CameraInFrames> cameras_;
  bool same_unit_;
  double drift_ = 0;
  std::vector<size_t> best_;  // those that agree with the best change so far
};

DepthCode Scaled(const DepthCode& code, double scale) {
  return code.known() ? EncodeDepth(scale * DepthOf(code), RelativeSigmaOf(code)) : code;
}

}  // namespace

std::optional<FrameChange> AlignFrames(const std::vector<CameraInFrames>& cameras, bool same_unit) {
  if (cameras.size() < kFewest) return std::nullopt;
  return Aligner(SpreadOver(cameras), same_unit).Find();
}

void ChangeFrame(const FrameChange& change, PoseLayer& layer) {
  const auto moved = [&change](Eigen::Isometry3d pose) {
    pose.linear() = change.rotation * pose.linear();
    pose.translation() = change.scale * change.rotation * pose.translation() + change.translation;
    return pose;
  };
  layer.noise.position_sigma *= change.scale;
  for (KeyframePose& pose : layer.keyframes) {
    pose = MakeKeyframePose(pose.keyframe, moved(pose.frame_from_camera()));
  }
  for (NodePose& pose : layer.nodes) {
    pose = MakeNodePose(pose.node, moved(pose.frame_from_camera()));
  }
  for (std::optional<NodePoseErrors>* errors : {&layer.appearance_errors, &layer.verified_errors}) {
    if (*errors) (*errors)->height_sigma *= change.scale;
  }
  for (PlanePose& plane : layer.planes) {
    Eigen::Matrix4d jacobian = Eigen::Matrix4d::Zero();
    jacobian.topLeftCorner<3, 3>() = change.rotation;
    jacobian.bottomLeftCorner<1, 3>() = change.translation.transpose() * change.rotation;
    jacobian(3, 3) = change.scale;
    plane.normal = (change.rotation * plane.normal).normalized();
    plane.distance = change.scale * plane.distance + plane.normal.dot(change.translation);
    plane.covariance = jacobian * plane.covariance * jacobian.transpose();
  }
  for (PlaneDepths& depths : layer.plane_depths) {
    for (DepthCode& code : depths.features) code = Scaled(code, change.scale);
  }
  for (LandmarkDepths& depths : layer.landmark_depths) {
    for (DepthCode& code : depths.landmarks) code = Scaled(code, change.scale);
  }
}

}  // namespace waystone
