// SPDX-License-Identifier: Apache-2.0
#include "builder/poses/structure.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "core/homography/homography.h"

namespace waystone {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kLeastPlanePoints = 8;
// A feature whose own depth is more than this many sigmas off its plane isn't on it.
constexpr double kOnPlaneSigmas = 3;
constexpr double kSamePixel_px = 0.5;
// Views in which a feature is searched for where its first depth puts it.
constexpr std::ptrdiff_t kNearestViews = 40;
constexpr double kSameDirectionCosine = 0.5;

// The feature's own depth and that of its plane, weighed; its own where they disagree.
UncertainDepth WeighDepths(const UncertainDepth& own, const UncertainDepth& plane) {
  const double own_variance = own.sigma * own.sigma;
  const double plane_variance = plane.sigma * plane.sigma;
  const double off = std::log(own.depth / plane.depth);
  if (off * off > kOnPlaneSigmas * kOnPlaneSigmas * (own_variance + plane_variance)) return own;
  const double share = own_variance / (own_variance + plane_variance);  // of the plane's
  return {own.depth * std::exp(-share * off), std::sqrt(share * plane_variance)};
}

}  // namespace

StructureEstimator::StructureEstimator(const MapData& map, const std::vector<PosedView>& views,
                                       const PoseTracks& tracks, const PoseOptions& options,
                                       double noise)
    : map_(map), views_(views), tracks_(tracks), options_(options) {
  for (int i = 0; i < std::ssize(views_); ++i) {
    view_of_[views_[i].keyframe->id] = i;
    grids_.emplace_back(*views_[i].features, options.near_px * noise);
  }
  near_.resize(views_.size());
  tbb::parallel_for(0, static_cast<int>(views_.size()), [&](int i) { near_[i] = NearestViews(i); });
}

int StructureEstimator::ViewOf(KeyframeId id) const {
  const auto found = view_of_.find(id);
  return found == view_of_.end() ? -1 : found->second;
}

PlacedPlane StructureEstimator::Place(const Plane& plane) const {
  const int view = ViewOf(plane.reference);
  PlacedPlane placed;
  std::vector<Anchored> anchored;
  std::vector<UncertainPoint> points;
  for (int f = 0; f < std::ssize(plane.features); ++f) {
    const Vector2d x = PositionOf(plane.features[f].reference);
    const Anchored one = Anchor(view, x, plane.descriptors.row(f), SightingsOf(plane, f));
    anchored.push_back(one);
    if (one.estimate.error == DepthError::kNone) points.push_back(PointOf(view, one));
  }
  placed.fit = FitPlane(points, kLeastPlanePoints);
  if (placed.fit) {
    TurnAway(views_[view].frame_from_camera, placed.fit->normal, placed.fit->distance);
  }
  for (const Anchored& one : anchored) {
    placed.features.push_back(Combine(view, one, placed.fit));
  }
  return placed;
}

std::vector<PlacedFeature> StructureEstimator::PlaceLandmarks(const Keyframe& keyframe) const {
  const int view = ViewOf(keyframe.id);
  std::vector<PlacedFeature> placed;
  for (const ImagePosition& position : keyframe.landmarks.positions) {
    const Vector2d x = DecodePosition(position, keyframe.width, keyframe.height);
    const Anchored one = Anchor(view, x, DescriptorAt(view, x), SightingsAt(view, x));
    placed.push_back(Combine(view, one, std::nullopt));
  }
  return placed;
}

// First by the links, and then by all views that show it where these predict it.
StructureEstimator::Anchored StructureEstimator::Anchor(
    int view, const Vector2d& x, const uint8_t* descriptor,
    const std::vector<FeatureLink>& links) const {
  Anchored anchored;
  const Camera& camera = views_[view].camera;
  anchored.ray = Unproject(camera, x);
  const auto back = Project(camera, anchored.ray);
  anchored.sees = back && (*back - x).norm() < kSamePixel_px;
  if (!anchored.sees) return anchored;
  anchored.estimate = Estimate(view, anchored.ray, links);
  if (anchored.estimate.error != DepthError::kNone || !descriptor) return anchored;
  const std::vector<FeatureLink> more =
      SearchViews(view, anchored.estimate.depth * anchored.ray, descriptor, links);
  if (more.size() == links.size()) return anchored;
  const DepthEstimate better = Estimate(view, anchored.ray, more);
  if (better.error == DepthError::kNone && better.inliers > anchored.estimate.inliers) {
    anchored.estimate = better;
  }
  return anchored;
}

DepthEstimate StructureEstimator::Estimate(int view, const Vector3d& ray,
                                           const std::vector<FeatureLink>& links) const {
  std::vector<RaySighting> sightings;
  for (const FeatureLink& link : links) {
    const PosedView& other = views_[link.view];
    sightings.push_back({other.frame_from_camera.inverse() * views_[view].frame_from_camera,
                         other.rays[link.feature], other.sigma_rad});
  }
  return EstimateDepth(ray, sightings, options_.depth);
}

// The links, and the features of a point (in the camera of `view`) in the other nearest views.
std::vector<FeatureLink> StructureEstimator::SearchViews(
    int view, const Vector3d& x_camera, const uint8_t* descriptor,
    const std::vector<FeatureLink>& links) const {
  std::vector<FeatureLink> found = links;
  const Vector3d x = views_[view].frame_from_camera * x_camera;
  const double limit = DistanceAt(map_.info.feature_type, options_.max_descriptor_distance);
  for (const int other : near_[view]) {
    const bool linked =
        std::ranges::any_of(links, [&](const FeatureLink& link) { return link.view == other; });
    if (linked) continue;
    const auto pixel = Project(views_[other].camera, views_[other].frame_from_camera.inverse() * x);
    const int feature = pixel ? grids_[other].MostAlike(*pixel, descriptor, limit) : -1;
    if (feature >= 0) found.push_back({other, feature});
  }
  return found;
}

// The nearest views that look in much the same direction.
std::vector<int> StructureEstimator::NearestViews(int view) const {
  const Isometry3d& pose = views_[view].frame_from_camera;
  std::vector<std::pair<double, int>> near;
  for (int other = 0; other < std::ssize(views_); ++other) {
    const Isometry3d& there = views_[other].frame_from_camera;
    const double cosine = there.linear().col(2).dot(pose.linear().col(2));
    if (other == view || cosine < kSameDirectionCosine) continue;
    near.emplace_back((there.translation() - pose.translation()).norm(), other);
  }
  const auto end = near.begin() + std::min(std::ssize(near), kNearestViews);
  std::ranges::partial_sort(near, end);
  std::vector<int> nearest;
  for (auto at = near.begin(); at != end; ++at) nearest.push_back(at->second);
  return nearest;
}

// Where the other views of a plane show a feature, by its homographies.
std::vector<FeatureLink> StructureEstimator::SightingsOf(const Plane& plane, int feature) const {
  std::vector<FeatureLink> links;
  const Vector2d x = PositionOf(plane.features[feature].reference);
  const double limit = DistanceAt(map_.info.feature_type, options_.max_descriptor_distance);
  for (const PlaneView& seen : plane.views) {
    const int view = ViewOf(seen.keyframe);
    if (view < 0 || seen.keyframe == plane.reference) continue;
    const Vector2d there = Apply(seen.reference_from_keyframe.inverse(), x);
    const int found = grids_[view].MostAlike(there, plane.descriptors.row(feature), limit);
    if (found >= 0) links.push_back({view, found});
  }
  return links;
}

// The links of all features at a position of a view: one that has several orientations is
// several features.
std::vector<FeatureLink> StructureEstimator::SightingsAt(int view, const Vector2d& x) const {
  std::vector<FeatureLink> links;
  for (int f = 0; f < views_[view].features->size(); ++f) {
    if ((PositionOf(views_[view].features->keypoints[f]) - x).norm() > kSamePixel_px) continue;
    const std::vector<FeatureLink>& found = tracks_.LinksOf(view, f);
    links.insert(links.end(), found.begin(), found.end());
  }
  return links;
}

// Null where the view has no feature.
const uint8_t* StructureEstimator::DescriptorAt(int view, const Vector2d& x) const {
  const Features& features = *views_[view].features;
  for (int f = 0; f < features.size(); ++f) {
    if ((PositionOf(features.keypoints[f]) - x).norm() <= kSamePixel_px) {
      return features.descriptors.row(f);
    }
  }
  return nullptr;
}

UncertainPoint StructureEstimator::PointOf(int view, const Anchored& one) const {
  const double depth = one.estimate.depth;
  const Isometry3d& pose = views_[view].frame_from_camera;
  const Vector3d direction = pose.linear() * one.ray;
  return {pose.translation() + depth * direction, depth * one.estimate.relative_sigma * direction,
          depth * views_[view].sigma_rad};
}

PlacedFeature StructureEstimator::Combine(int view, const Anchored& one,
                                          const std::optional<FittedPlane>& plane) const {
  PlacedFeature placed;
  placed.contradicts = one.estimate.error == DepthError::kContradiction;
  if (placed.contradicts || !one.sees) return placed;
  const auto met =
      plane ? MeetPlane(views_[view].frame_from_camera, one.ray, *plane) : std::nullopt;
  const UncertainDepth own{one.estimate.depth, one.estimate.relative_sigma};
  if (one.estimate.error == DepthError::kNone) {
    const UncertainDepth depth = met ? WeighDepths(own, *met) : own;
    placed.depth = EncodeDepth(depth.depth, depth.sigma);
  } else if (met && met->sigma <= options_.depth.max_relative_sigma) {
    placed.depth = EncodeDepth(met->depth, met->sigma);
  }
  return placed;
}

}  // namespace waystone
