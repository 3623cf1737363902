// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <map>
#include <string>

#include "schema/layers/layer_problems.h"

namespace waystone {
namespace {

// How far a norm may be from 1: rounding.
constexpr double kNormRounding = 1e-9;

bool IsSigma(double value) { return std::isfinite(value) && value >= 0; }

class PoseProblemFinder {
 public:
  PoseProblemFinder(const MapData& map, std::vector<MapProblem>& problems)
      : layer_(*map.poses), problems_(problems) {
    for (const Keyframe& keyframe : map.keyframes) {
      landmarks_[keyframe.id] = keyframe.landmarks.size();
    }
    for (const Plane& plane : map.planes) {
      planes_[plane.id] = {plane.reference, static_cast<int>(plane.features.size())};
    }
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
    Require(std::abs(pose.rotation.norm() - 1) <= kNormRounding && pose.rotation.w() >= 0, where,
            "its quaternion isn't of norm 1 with w of at least 0");
    Require(pose.position.allFinite(), where, "its position is not finite");
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
  std::vector<MapProblem>& problems_;
  std::map<KeyframeId, int> landmarks_;                   // how many each keyframe has
  std::map<PlaneId, std::pair<KeyframeId, int>> planes_;  // reference and number of features
};

}  // namespace

void FindPoseProblems(const MapData& map, std::vector<MapProblem>& problems) {
  PoseProblemFinder(map, problems).Find();
}

}  // namespace waystone
