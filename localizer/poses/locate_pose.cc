// SPDX-License-Identifier: Apache-2.0
#include "localizer/poses/locate_pose.h"

#include <algorithm>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/base/text.h"
#include "core/camera/image_plane.h"
#include "core/features/keypoint_grid.h"
#include "localizer/poses/pose_sightings.h"

namespace waystone {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

const Camera* OwnCamera(const MapIndex& index, const Answer& answer, const Features& query) {
  const Keyframe* keyframe =
      answer.planes.keyframe ? index.FindKeyframe(answer.planes.keyframe->id) : nullptr;
  if (!keyframe) return nullptr;
  const std::optional<Camera>& camera = index.FindSequence(keyframe->sequence)->camera;
  const bool same_size = camera && cv::Size(camera->width, camera->height) == ImageSize(query);
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
    auto first = FindAbsolutePose(Sightings(std::move(matches)), options_.solve);
    if (!first || options_.keyframes == 0) return first;
    auto refined = RefineAbsolutePose(Sightings(Search(first->world_from_camera)),
                                      first->world_from_camera, options_.solve);
    return refined && refined->inliers.size() >= first->inliers.size() ? refined : first;
  }

 private:
  std::vector<PointSighting> Sightings(std::vector<MapMatch> matches) const {
    return MakePointSightings(index_, query_, camera_, sigma_rad_, std::move(matches));
  }

  // The nearest keyframes' features that the query shows where a pose predicts them.
  std::vector<MapMatch> Search(const Isometry3d& frame_from_query) const {
    const KeypointGrid grid(query_, options_.search_px);
    const Isometry3d query_from_frame = frame_from_query.inverse();
    std::vector<MapMatch> matches;
    std::set<int> planes;
    for (const int keyframe : NearestPosedKeyframes(index_, frame_from_query, options_.keyframes)) {
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

// The covariance of the errors that the points of one keyframe share.
Matrix6d CovarianceOf(const PoseNoise& noise) {
  Matrix6d covariance = Matrix6d::Zero();
  covariance.diagonal().head<3>().setConstant(noise.position_sigma * noise.position_sigma);
  covariance.diagonal().tail<3>().setConstant(noise.rotation_sigma_rad * noise.rotation_sigma_rad);
  return covariance;
}

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
  // Of several images of a request, only the first must have the camera's size.
  const cv::Size size = ImageSize(query);
  if (camera && cv::Size(camera->width, camera->height) != size) {
    answer.pose_reason = "the camera has " + SizeText(camera->width, camera->height) +
                         " pixels, the photo has " + SizeText(size.width, size.height) +
                         "; send it in a request of its own, with its camera";
    return;
  }
  const Camera* own = camera ? nullptr : OwnCamera(index, answer, query);
  if (!camera && !own) {
    answer.pose_reason =
        "the camera isn't known; send fx, fy, cx and cy, fov or the name of a camera of the map";
    return;
  }
  const Camera working = ScaledCamera(camera ? *camera : *own, query.width);
  const auto pose = PoseFinder(index, query, working, options).Find(answer.planes.matches);
  if (!pose) {
    answer.pose_reason = std::to_string(CountPlaced(index, answer.planes.matches)) +
                         " of the matches have a position in the map's frame, and no pose fits " +
                         std::to_string(options.solve.min_inliers) + " of them";
    return;
  }
  answer.pose = QueryPose{.frame = layer->frame,
                          .unit = layer->unit,
                          .frame_from_camera = pose->world_from_camera,
                          .covariance = pose->covariance + CovarianceOf(layer->noise),
                          .inliers = static_cast<int>(pose->inliers.size()),
                          .by_own_camera = own != nullptr};
}

}  // namespace waystone
