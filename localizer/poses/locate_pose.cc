// SPDX-License-Identifier: Apache-2.0
#include "localizer/poses/locate_pose.h"

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/camera/image_plane.h"
#include "core/features/keypoint_grid.h"

namespace waystone {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// A keyframe that looks in another direction shows little of what the query does.
constexpr double kSameDirectionCosine = 0.5;

const Camera* OwnCamera(const MapIndex& index, const Answer& answer, const Features& query) {
  const Keyframe* keyframe =
      answer.planes.keyframe ? index.FindKeyframe(answer.planes.keyframe->id) : nullptr;
  if (!keyframe) return nullptr;
  const std::optional<Camera>& camera = index.FindSequence(keyframe->sequence)->camera;
  const bool same_size = camera && camera->width == query.width && camera->height == query.height;
  return same_size ? &*camera : nullptr;
}

class PoseFinder {
 public:
  PoseFinder(const MapIndex& index, const Features& query, const Camera& camera,
             const PoseQueryOptions& options)
      : index_(index), query_(query), camera_(camera), options_(options) {
    sigma_rad_ = options.keypoint_sigma_px * RadiansPerPixel(camera);
  }

  std::optional<AbsolutePose> Find(std::vector<MapMatch> matches) const {
    auto first = FindAbsolutePose(MakeSightings(std::move(matches)), options_.solve);
    if (!first || options_.keyframes == 0) return first;
    auto refined = RefineAbsolutePose(MakeSightings(Search(first->world_from_camera)),
                                      first->world_from_camera, options_.solve);
    return refined && refined->inliers.size() >= first->inliers.size() ? refined : first;
  }

 private:
  // Each match once; those that share a keypoint share its weight.
  std::vector<PointSighting> MakeSightings(std::vector<MapMatch> matches) const {
    std::ranges::sort(matches);
    matches.erase(std::unique(matches.begin(), matches.end()), matches.end());
    std::map<int, int> of_keypoint;
    for (const MapMatch& match : matches) {
      of_keypoint[match.keypoint] += index_.points()[match.row].known() ? 1 : 0;
    }
    std::vector<PointSighting> sightings;
    for (const MapMatch& match : matches) {
      const MapPoint& point = index_.points()[match.row];
      if (!point.known()) continue;
      sightings.push_back({.point = point.x.cast<double>(),
                           .along = point.along.cast<double>(),
                           .across = point.depth * sigma_rad_,
                           .ray = Unproject(camera_, PositionOf(query_.keypoints[match.keypoint])),
                           .sigma_rad = sigma_rad_,
                           .weight = 1.0 / of_keypoint[match.keypoint]});
    }
    return sightings;
  }

  // Keyframes with poses that look in much the same direction, the nearest first.
  std::vector<int> NearestKeyframes(const Isometry3d& frame_from_query) const {
    std::vector<std::pair<double, int>> near;
    for (const KeyframePose& pose : index_.map().poses->keyframes) {
      const Vector3d gaze = pose.rotation * Vector3d::UnitZ();
      const double cosine = gaze.dot(frame_from_query.linear().col(2));
      if (cosine < kSameDirectionCosine) continue;
      const double distance = (pose.position - frame_from_query.translation()).norm();
      near.emplace_back(distance / cosine, index_.IndexOf(pose.keyframe));
    }
    std::ranges::sort(near);
    near.resize(std::min(near.size(), static_cast<size_t>(options_.keyframes)));
    std::vector<int> keyframes;
    for (const auto& [cost, keyframe] : near) keyframes.push_back(keyframe);
    return keyframes;
  }

  // What the query shows of the nearest keyframes' features where a pose puts them.
  std::vector<MapMatch> Search(const Isometry3d& frame_from_query) const {
    const KeypointGrid grid(query_, options_.search_px);
    const Isometry3d query_from_frame = frame_from_query.inverse();
    std::vector<MapMatch> matches;
    std::set<int> planes;
    for (const int keyframe : NearestKeyframes(frame_from_query)) {
      SearchRows(grid, query_from_frame, index_.FirstLandmarkRow(keyframe),
                 index_.LandmarkDescriptorsOf(keyframe), matches);
      for (const MapIndex::SeenPlane& seen : index_.PlanesSeenBy(keyframe)) {
        planes.insert(seen.plane);
      }
    }
    for (const int plane : planes) {
      SearchRows(grid, query_from_frame, index_.FirstRow(plane), index_.DescriptorsOf(plane),
                 matches);
    }
    return matches;
  }

  void SearchRows(const KeypointGrid& grid, const Isometry3d& query_from_frame, int first,
                  const Descriptors& descriptors, std::vector<MapMatch>& matches) const {
    const double limit = DistanceAt(query_.type, options_.max_descriptor_distance);
    for (int i = 0; i < descriptors.rows(); ++i) {
      const MapPoint& point = index_.points()[first + i];
      if (!point.known()) continue;
      const auto pixel = Project(camera_, query_from_frame * point.x.cast<double>());
      if (!pixel) continue;
      const int keypoint = grid.MostAlike(*pixel, descriptors.row(i), limit);
      if (keypoint >= 0) matches.push_back({keypoint, first + i});
    }
  }

  const MapIndex& index_;
  const Features& query_;
  const Camera& camera_;
  const PoseQueryOptions& options_;
  double sigma_rad_ = 0;
};

// Keypoints of the query whose match has a position.
int CountPlaced(const MapIndex& index, const std::vector<MapMatch>& matches) {
  std::set<int> keypoints;
  for (const MapMatch& match : matches) {
    if (index.points()[match.row].known()) keypoints.insert(match.keypoint);
  }
  return static_cast<int>(keypoints.size());
}

}  // namespace

void AddPose(const MapIndex& index, const Features& query, const std::optional<Camera>& camera,
             const PoseQueryOptions& options, Answer& answer) {
  const std::optional<PoseLayer>& layer = index.map().poses;
  if (!layer) return;
  if (answer.verdict != Verdict::kLocalized) {
    answer.pose_reason = "not localized";
    return;
  }
  const Camera* own = camera ? nullptr : OwnCamera(index, answer, query);
  if (!camera && !own) {
    answer.pose_reason =
        "the camera isn't known; send fx, fy, cx and cy, fov or the name of a camera of the map";
    return;
  }
  const auto pose =
      PoseFinder(index, query, camera ? *camera : *own, options).Find(answer.planes.matches);
  if (!pose) {
    answer.pose_reason = std::to_string(CountPlaced(index, answer.planes.matches)) +
                         " of the matches have a position in the map's frame, and no pose fits " +
                         std::to_string(options.solve.min_inliers) + " of them";
    return;
  }
  answer.pose = QueryPose{.frame = layer->frame,
                          .unit = layer->unit,
                          .frame_from_camera = pose->world_from_camera,
                          .covariance = pose->covariance,
                          .inliers = static_cast<int>(pose->inliers.size()),
                          .by_own_camera = own != nullptr};
}

}  // namespace waystone
