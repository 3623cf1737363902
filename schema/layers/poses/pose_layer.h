// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/ids.h"

// The pose layer of a map: where its keyframes, planes and features are in a frame given by the
// user. FORMAT.md says how each field is stored. All functions are pure; thread-safe.
namespace waystone {

// The layer's unit of length. The values are written into map files: never change them.
enum class LengthUnit { kUnknown = 0, kMetres = 1 };
std::string_view NameOf(LengthUnit unit);  // "unknown", "metres"

// How far a feature is along the ray of its pixel, in 4 bytes: relative steps of 0.034 % from
// 2^-16 to 2^16, and its standard deviation as a share of it.
struct DepthCode {
  uint16_t log_depth = 0;  // log2(depth) = (log_depth - 32768) / 2048; 0 where it isn't known
  uint16_t sigma = 0;      // standard deviation over depth, in 65535ths

  bool known() const { return log_depth != 0; }
  bool operator==(const DepthCode&) const = default;
};
// The code of a depth and its relative standard deviation; that of an unknown depth where it is out
// of range.
DepthCode EncodeDepth(double depth, double relative_sigma);
double DepthOf(const DepthCode& code);          // distance from the camera, in the layer's unit
double RelativeSigmaOf(const DepthCode& code);  // in [0, 1]

// x_frame = rotation x_camera + position; the camera has x right, y down, z forward.
struct CameraPose {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  // unit, w of 0 or more
  Eigen::Vector3d position = Eigen::Vector3d::Zero();

  Eigen::Isometry3d frame_from_camera() const;
  bool operator==(const CameraPose& other) const;
};
CameraPose MakeCameraPose(const Eigen::Isometry3d& frame_from_camera);

struct KeyframePose : CameraPose {
  KeyframeId keyframe;

  bool operator==(const KeyframePose&) const = default;
};
KeyframePose MakeKeyframePose(KeyframeId keyframe, const Eigen::Isometry3d& frame_from_camera);

// The pose of a panorama, whose camera's z points to its middle column. The node's own pose
// (AppearanceNode::pose) is this one as Horizontal sees it.
struct NodePose : CameraPose {
  AppearanceNodeId node;

  bool operator==(const NodePose&) const = default;
};
NodePose MakeNodePose(AppearanceNodeId node, const Eigen::Isometry3d& frame_from_camera);

// How far answers about panoramas are from the given poses, beyond the answers' own uncertainty, as
// measured by builder/calibration/node_pose_calibration on panoramas of the map.
struct NodePoseErrors {
  double position_factor = 1;    // on the standard deviation of the position on the ground
  double height_sigma = 0;       // in the layer's unit
  double heading_sigma_rad = 0;  // in addition to that of the answer's heading
  double tilt_sigma_rad = 0;     // about each level axis

  bool operator==(const NodePoseErrors&) const = default;
};

// The plane n . x = d of the frame, fitted to its features in all views. n is of unit length and
// points away from the camera of its reference keyframe.
struct PlanePose {
  PlaneId plane;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double distance = 0;
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();  // of (n, d); of rank 3

  bool operator==(const PlanePose&) const = default;
};

// Depths of a plane's features, in the camera of its reference keyframe.
struct PlaneDepths {
  PlaneId plane;
  std::vector<DepthCode> features;  // as many as the plane has

  bool operator==(const PlaneDepths&) const = default;
};

// Depths of a keyframe's landmarks.
struct LandmarkDepths {
  KeyframeId keyframe;
  std::vector<DepthCode> landmarks;  // as many as the keyframe has

  bool operator==(const LandmarkDepths&) const = default;
};

// How inconsistent the given poses are, as measured by builder/calibration/pose_calibration:
// standard deviations on each axis. 0 where they could not be measured.
struct PoseNoise {
  double position_sigma = 0;  // in the layer's unit
  double rotation_sigma_rad = 0;

  bool operator==(const PoseNoise&) const = default;
};

struct PoseLayer {
  std::string frame;  // its name, chosen by the user: "map", "earth", ...
  LengthUnit unit = LengthUnit::kUnknown;
  PoseNoise noise;
  std::vector<KeyframePose> keyframes;  // each list is ordered by id
  std::vector<PlanePose> planes;
  std::vector<PlaneDepths> plane_depths;        // of reference keyframes with pose and camera
  std::vector<LandmarkDepths> landmark_depths;  // of keyframes with pose and camera
  // Of panoramas. Where there are any, the appearance layer is in this frame as seen from above.
  std::vector<NodePose> nodes;
  // For answers by appearance only, and for those that were verified by features; nothing where
  // they could not be measured.
  std::optional<NodePoseErrors> appearance_errors;
  std::optional<NodePoseErrors> verified_errors;

  // The pose of a keyframe, and of a node; null where it has none.
  const KeyframePose* Find(KeyframeId id) const;
  const NodePose* Find(AppearanceNodeId id) const;
  bool operator==(const PoseLayer&) const = default;
};

}  // namespace waystone
