// SPDX-License-Identifier: Apache-2.0
#include "localizer/poses/pose_sightings.h"

#include <algorithm>
#include <map>
#include <utility>

namespace waystone {
namespace {

// A keyframe that looks in another direction shares little with the camera's view.
constexpr double kAlikeGazeCosine = 0.5;

}  // namespace

std::vector<PointSighting> MakePointSightings(const MapIndex& index, const Features& query,
                                              const Camera& camera, double sigma_rad,
                                              std::vector<MapMatch> matches) {
  std::ranges::sort(matches);
  matches.erase(std::unique(matches.begin(), matches.end()), matches.end());
  std::map<int, int> of_keypoint;
  for (const MapMatch& match : matches) {
    of_keypoint[match.keypoint] += index.points()[match.row].known() ? 1 : 0;
  }
  std::vector<PointSighting> sightings;
  for (const MapMatch& match : matches) {
    const MapPoint& point = index.points()[match.row];
    if (!point.known()) continue;
    sightings.push_back({.point = point.x.cast<double>(),
                         .along = point.along.cast<double>(),
                         .across = point.depth * sigma_rad,
                         .ray = Unproject(camera, PositionOf(query.keypoints[match.keypoint])),
                         .sigma_rad = sigma_rad,
                         .weight = 1.0 / of_keypoint[match.keypoint]});
  }
  return sightings;
}

std::vector<int> NearestPosedKeyframes(const MapIndex& index,
                                       const Eigen::Isometry3d& frame_from_camera, int count,
                                       const std::function<bool(int)>& admits) {
  std::vector<std::pair<double, int>> near;
  for (const KeyframePose& pose : index.map().poses->keyframes) {
    const Eigen::Vector3d gaze = pose.rotation * Eigen::Vector3d::UnitZ();
    const double cosine = gaze.dot(frame_from_camera.linear().col(2));
    const int keyframe = index.IndexOf(pose.keyframe);
    if (cosine < kAlikeGazeCosine || (admits && !admits(keyframe))) continue;
    const double distance = (pose.position - frame_from_camera.translation()).norm();
    near.emplace_back(distance / cosine, keyframe);
  }
  std::ranges::sort(near);
  near.resize(std::min(near.size(), static_cast<size_t>(count)));
  std::vector<int> keyframes;
  for (const auto& [cost, keyframe] : near) keyframes.push_back(keyframe);
  return keyframes;
}

}  // namespace waystone
