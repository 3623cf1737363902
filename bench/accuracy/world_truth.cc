// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/world_truth.h"

#include <tbb/parallel_for.h>

#include <Eigen/Dense>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/camera/image_plane.h"
#include "core/features/match.h"
#include "core/homography/homography.h"
#include "schema/layers/names/place_names.h"

namespace waystone::bench {
namespace {

constexpr int kEdge_px = 3;
constexpr int kGrid_px = 4;  // pixels counted in both directions

std::string Key(const Descriptors& descriptors, int row) {
  return {reinterpret_cast<const char*>(descriptors.row(row)),
          static_cast<size_t>(descriptors.bytes())};
}

bool IsInImage(const Eigen::Vector2d& x, const Camera& camera) {
  return x.x() >= 0 && x.y() >= 0 && x.x() < camera.width && x.y() < camera.height;
}

int PlaneAt(const cv::Mat& ids, const Eigen::Vector2d& x) {
  const int column = static_cast<int>(std::lround(x.x()));
  const int row = static_cast<int>(std::lround(x.y()));
  if (column < 0 || row < 0 || column >= ids.cols || row >= ids.rows) return 0;
  return ids.at<uint16_t>(row, column);
}

}  // namespace

std::set<int> PlanesNear(const cv::Mat& plane_ids, const Eigen::Vector2d& x) {
  std::set<int> near;
  for (int dy = -kEdge_px; dy <= kEdge_px; dy += kEdge_px) {
    for (int dx = -kEdge_px; dx <= kEdge_px; dx += kEdge_px) {
      near.insert(PlaneAt(plane_ids, x + Eigen::Vector2d(dx, dy)));
    }
  }
  return near;
}

WorldTruth::WorldTruth(const World& world, const WorldSource& source, const Walk& walk,
                       const MapData& map, const FeatureOptions& features)
    : world_(world),
      walk_(walk),
      map_(map),
      camera_(ScaledCamera(*source.camera(), map.keyframes.front().width)),
      image_px_(static_cast<double>(source.camera()->width) / camera_.width) {
  plane_ids_.resize(map.keyframes.size());
  features_.resize(map.keyframes.size());
  tbb::parallel_for(size_t{0}, map.keyframes.size(), [&](size_t k) {
    const RenderedFrame frame = source.Render(map.keyframes[k].frame);
    features_[k] = ExtractFeatures(frame.grey, features);
    cv::resize(frame.plane_ids, plane_ids_[k], {features_[k].width, features_[k].height}, 0, 0,
               cv::INTER_NEAREST_EXACT);
  });
  for (int k = 0; k < static_cast<int>(features_.size()); ++k) {
    for (int i = 0; i < features_[k].size(); ++i) {
      seen_.emplace(Key(features_[k].descriptors, i), std::pair(k, i));
    }
  }
}

WorldTruth::Owner WorldTruth::OwnerOf(const Plane& plane) const {
  std::map<int, int> counts;
  int counted = 0;
  for (int f = 0; f < plane.descriptors.rows(); ++f) {
    const auto seen = seen_.find(Key(plane.descriptors, f));
    if (seen == seen_.end()) continue;
    const auto [keyframe, keypoint] = seen->second;
    ++counted;
    for (int id :
         PlanesNear(plane_ids_[keyframe], PositionOf(features_[keyframe].keypoints[keypoint]))) {
      ++counts[id];
    }
  }
  Owner owner;
  for (const auto& [id, count] : counts) {
    if (id != 0 && count > owner.share * counted) {
      owner = {id, static_cast<double>(count) / counted};
    }
  }
  return owner;
}

std::map<int, int> WorldTruth::CarriedMatches(int from, int to) const {
  std::map<int, int> carried;
  for (const Match& match : MatchDescriptors(features_[to].descriptors, features_[from].descriptors,
                                             features_[to].type, MatchOptions{})) {
    const Eigen::Vector2d x_to = PositionOf(features_[to].keypoints[match.a]);
    const Eigen::Vector2d x_from = PositionOf(features_[from].keypoints[match.b]);
    const int plane = PlaneAt(plane_ids_[to], x_to);
    if (plane == 0 || PlaneAt(plane_ids_[from], x_from) != plane) continue;
    const Eigen::Matrix3d from_to = ToFrom(plane, map_.keyframes[to].id, map_.keyframes[from].id);
    if ((Apply(from_to, x_to) - x_from).norm() < kTrueMatch_px) ++carried[plane];
  }
  return carried;
}

Eigen::Matrix3d WorldTruth::ToFrom(int true_plane, KeyframeId from, KeyframeId to) const {
  return PlaneHomography(world_.PlaneById(true_plane), camera_,
                         walk_.frames[map_.keyframes[IndexOf(from)].frame].world_from_camera,
                         walk_.frames[map_.keyframes[IndexOf(to)].frame].world_from_camera);
}

bool WorldTruth::Shows(KeyframeId keyframe, int true_plane) const {
  const cv::Mat& ids = plane_ids_[static_cast<size_t>(IndexOf(keyframe))];
  for (int y = 0; y < ids.rows; y += kGrid_px) {
    for (int x = 0; x < ids.cols; x += kGrid_px) {
      if (ids.at<uint16_t>(y, x) == true_plane) return true;
    }
  }
  return false;
}

WorldTruth::Outlined WorldTruth::PixelsInside(const std::vector<Eigen::Vector2d>& outline,
                                              KeyframeId reference, int true_plane) const {
  Outlined result;
  if (outline.size() < 3) return result;
  const cv::Mat& ids = plane_ids_[static_cast<size_t>(IndexOf(reference))];
  for (int y = 0; y < ids.rows; y += kGrid_px) {
    for (int x = 0; x < ids.cols; x += kGrid_px) {
      if (!Holds(outline, {x, y})) continue;
      ++result.pixels;
      result.of_plane += ids.at<uint16_t>(y, x) == true_plane;
    }
  }
  return result;
}

std::vector<double> WorldTruth::ViewErrors(const Plane& plane, const PlaneView& view,
                                           int true_plane) const {
  const Eigen::Matrix3d keyframe_from_reference =
      ToFrom(true_plane, plane.reference, view.keyframe);
  const Eigen::Matrix3d reference_from_keyframe = keyframe_from_reference.inverse();
  std::vector<double> errors;
  for (const PlaneFeature& feature : plane.features) {
    const Eigen::Vector2d x = Apply(keyframe_from_reference, PositionOf(feature.reference));
    if (!IsInImage(x, camera_)) continue;
    errors.push_back(
        image_px_ *
        (Apply(view.reference_from_keyframe, x) - Apply(reference_from_keyframe, x)).norm());
  }
  return errors;
}

}  // namespace waystone::bench
