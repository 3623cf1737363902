// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <map>
#include <string>

#include "schema/layers/layer_problems.h"
#include "schema/layers/poses/horizontal.h"

namespace waystone {
namespace {

// How far a norm may be from 1: rounding.
constexpr double kNormRounding = 1e-9;
constexpr double kSamePose = 1e-6;  // of the size of positions, and rad

bool IsSigma(double value) { return std::isfinite(value) && value >= 0; }

class PoseProblemFinder {
 public:
  PoseProblemFinder(const MapData& map, std::vector<MapProblem>& problems)
      : layer_(*map.poses), horizontal_(HorizontalOf(layer_)), problems_(problems) {
    for (const Keyframe& keyframe : map.keyframes) {
      landmarks_[keyframe.id] = keyframe.landmarks.size();
    }
    for (const Plane& plane : map.planes) {
      planes_[plane.id] = {plane.reference, static_cast<int>(plane.features.size())};
    }
    if (!map.appearance) return;
    for (const AppearanceNode& node : map.appearance->nodes) nodes_[node.id] = node.pose;
  }

  void Find() {
    const PoseNoise& noise = layer_.noise;
    Require(IsSigma(noise.position_sigma) && IsSigma(noise.rotation_sigma_rad), "pose_layer 1",
            "its standard deviations are not finite and 0 or more");
    CheckEach("keyframe_poses", layer_.keyframes, &KeyframePose::keyframe,
              [&](const auto& pose, const auto& where) { CheckPose(pose, where); });
    CheckEach("plane_poses", layer_.planes, &PlanePose::plane,
              [&](const auto& plane, const auto& where) { CheckPlane(plane, where); });
    CheckEach("plane_depths", layer_.plane_depths, &PlaneDepths::plane,
              [&](const auto& depths, const auto& where) { CheckPlaneDepths(depths, where); });
    CheckEach("landmark_depths", layer_.landmark_depths, &LandmarkDepths::keyframe,
              [&](const auto& depths, const auto& where) { CheckLandmarkDepths(depths, where); });
    CheckEach("node_poses", layer_.nodes, &NodePose::node,
              [&](const auto& pose, const auto& where) { CheckNodePose(pose, where); });
    CheckErrors("node_pose_errors 1", layer_.appearance_errors);
    CheckErrors("node_pose_errors 2", layer_.verified_errors);
  }

 private:
  void Require(bool holds, const std::string& where, const std::string& message) {
    if (!holds) problems_.push_back({where, message});
  }

  template <class Item, class Id, class Check>
  void CheckEach(const std::string& table, const std::vector<Item>& items, Id Item::*id,
                 const Check& check) {
    int64_t last = 0;
    for (const Item& item : items) {
      const int64_t now = (item.*id).value;
      const std::string where = table + " " + std::to_string(now);
      Require(now > last, where,
              "ids must be positive and increasing; the previous one is " + std::to_string(last));
      last = now;
      check(item, where);
    }
  }

  void CheckPose(const KeyframePose& pose, const std::string& where) {
    Require(landmarks_.contains(pose.keyframe), where, "no such keyframe");
    CheckCameraPose(pose, where);
  }

  void CheckCameraPose(const CameraPose& pose, const std::string& where) {
    Require(std::abs(pose.rotation.norm() - 1) <= kNormRounding && pose.rotation.w() >= 0, where,
            "its quaternion isn't of norm 1 with w of at least 0");
    Require(pose.position.allFinite(), where, "its position is not finite");
  }

  void CheckNodePose(const NodePose& pose, const std::string& where) {
    const auto node = nodes_.find(pose.node);
    Require(node != nodes_.end(), where, "no such node");
    CheckCameraPose(pose, where);
    if (node == nodes_.end()) return;
    const Pose2 above = horizontal_.Of(pose);
    const Pose2& own = node->second;
    const double limit = kSamePose * (1 + pose.position.norm());
    Require(std::hypot(above.x - own.x, above.y - own.y) <= limit &&
                std::abs(WrappedAngle(above.theta_rad - own.theta_rad)) <= kSamePose,
            where, "seen from above it isn't the pose of its node");
  }

  void CheckErrors(const std::string& where, const std::optional<NodePoseErrors>& errors) {
    Require(!errors || (IsSigma(errors->position_factor) && IsSigma(errors->height_sigma) &&
                        IsSigma(errors->heading_sigma_rad) && IsSigma(errors->tilt_sigma_rad)),
            where, "its values are not finite and 0 or more");
  }

  void CheckPlane(const PlanePose& plane, const std::string& where) {
    Require(planes_.contains(plane.plane), where, "no such plane");
    Require(std::abs(plane.normal.norm() - 1) <= kNormRounding, where,
            "its normal isn't of length 1");
    Require(std::isfinite(plane.distance) && plane.covariance.allFinite(), where,
            "its distance or covariance is not finite");
  }

  void CheckPlaneDepths(const PlaneDepths& depths, const std::string& where) {
    const auto plane = planes_.find(depths.plane);
    Require(plane != planes_.end(), where, "no such plane");
    if (plane == planes_.end()) return;
    CheckCount(std::ssize(depths.features), plane->second.second, "features", where);
    CheckPosed(plane->second.first, where);
  }

  void CheckLandmarkDepths(const LandmarkDepths& depths, const std::string& where) {
    const auto keyframe = landmarks_.find(depths.keyframe);
    Require(keyframe != landmarks_.end(), where, "no such keyframe");
    if (keyframe == landmarks_.end()) return;
    CheckCount(std::ssize(depths.landmarks), keyframe->second, "landmarks", where);
    CheckPosed(depths.keyframe, where);
  }

  void CheckCount(int64_t depths, int64_t things, const std::string& name,
                  const std::string& where) {
    Require(depths == things, where,
            std::to_string(depths) + " depths for " + std::to_string(things) + " " + name);
  }

  void CheckPosed(KeyframeId keyframe, const std::string& where) {
    Require(layer_.Find(keyframe) != nullptr, where,
            "keyframe " + std::to_string(keyframe.value) + " has no pose");
  }

  const PoseLayer& layer_;
  const Horizontal horizontal_;
  std::vector<MapProblem>& problems_;
  std::map<KeyframeId, int> landmarks_;                   // how many each keyframe has
  std::map<PlaneId, std::pair<KeyframeId, int>> planes_;  // reference and number of features
  std::map<AppearanceNodeId, Pose2> nodes_;
};

}  // namespace

void FindPoseProblems(const MapData& map, std::vector<MapProblem>& problems) {
  PoseProblemFinder(map, problems).Find();
}

}  // namespace waystone
