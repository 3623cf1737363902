// SPDX-License-Identifier: Apache-2.0
#include "schema/layers/poses/pose_layer.h"

#include <algorithm>
#include <cmath>

namespace waystone {
namespace {

constexpr double kStepsPerOctave = 2048;
constexpr int kUnitDepth = 32768;
constexpr int kLargestCode = 65535;

}  // namespace

std::string_view NameOf(LengthUnit unit) {
  return unit == LengthUnit::kMetres ? "metres" : "unknown";
}

DepthCode EncodeDepth(double depth, double relative_sigma) {
  if (!(depth > 0) || !std::isfinite(depth) || !(relative_sigma >= 0)) return {};
  const double code = std::round(std::log2(depth) * kStepsPerOctave) + kUnitDepth;
  if (code < 1 || code > kLargestCode) return {};
  const double sigma = std::ceil(std::min(1.0, relative_sigma) * kLargestCode);
  return {static_cast<uint16_t>(code), static_cast<uint16_t>(sigma)};
}

double DepthOf(const DepthCode& code) {
  return std::exp2((code.log_depth - kUnitDepth) / kStepsPerOctave);
}

double RelativeSigmaOf(const DepthCode& code) {
  return static_cast<double>(code.sigma) / kLargestCode;
}

Eigen::Isometry3d CameraPose::frame_from_camera() const {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = rotation.toRotationMatrix();
  pose.translation() = position;
  return pose;
}

bool CameraPose::operator==(const CameraPose& other) const {
  return rotation.coeffs() == other.rotation.coeffs() && position == other.position;
}

CameraPose MakeCameraPose(const Eigen::Isometry3d& frame_from_camera) {
  CameraPose pose{Eigen::Quaterniond(frame_from_camera.linear()).normalized(),
                  frame_from_camera.translation()};
  if (pose.rotation.w() < 0) pose.rotation.coeffs() *= -1;
  return pose;
}

KeyframePose MakeKeyframePose(KeyframeId keyframe, const Eigen::Isometry3d& frame_from_camera) {
  return {MakeCameraPose(frame_from_camera), keyframe};
}

NodePose MakeNodePose(AppearanceNodeId node, const Eigen::Isometry3d& frame_from_camera) {
  return {MakeCameraPose(frame_from_camera), node};
}

const KeyframePose* PoseLayer::Find(KeyframeId id) const {
  const auto found = std::ranges::lower_bound(keyframes, id, {}, &KeyframePose::keyframe);
  return found == keyframes.end() || found->keyframe != id ? nullptr : &*found;
}

const NodePose* PoseLayer::Find(AppearanceNodeId id) const {
  const auto found = std::ranges::lower_bound(nodes, id, {}, &NodePose::node);
  return found == nodes.end() || found->node != id ? nullptr : &*found;
}

}  // namespace waystone
