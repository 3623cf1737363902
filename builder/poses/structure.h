// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "builder/poses/options.h"
#include "builder/poses/plane_fit.h"
#include "builder/poses/pose_tracks.h"
#include "core/features/keypoint_grid.h"
#include "schema/map_data.h"

namespace waystone {

// A feature's depth, and whether its sightings contradict the poses.
struct PlacedFeature {
  DepthCode depth;
  bool contradicts = false;
};

struct PlacedPlane {
  std::vector<PlacedFeature> features;
  std::optional<FittedPlane> fit;
};

// Estimates where the features of a map's planes and landmarks are, with fixed poses. A feature
// stays on its stored ray; its distance follows from the views that show it: those given by its
// plane's homographies or the tracks, and then all near ones in which it is found where these
// predict it. Refers to its arguments. Deterministic; thread-safe.
class StructureEstimator {
 public:
  // `noise`: the factor by which the poses' own errors enlarge those of keypoints, 1 or more.
  StructureEstimator(const MapData& map, const std::vector<PosedView>& views,
                     const PoseTracks& tracks, const PoseOptions& options, double noise);

  // The index of a keyframe's view; -1 where it has no pose.
  int ViewOf(KeyframeId id) const;
  // Places a plane whose reference keyframe has a pose.
  PlacedPlane Place(const Plane& plane) const;
  // Places the landmarks of a keyframe with a pose.
  std::vector<PlacedFeature> PlaceLandmarks(const Keyframe& keyframe) const;

 private:
  // A feature on its ray in the keyframe that it is stored with.
  struct Anchored {
    Eigen::Vector3d ray;
    bool sees = false;  // the camera's model reaches its pixel
    DepthEstimate estimate;
  };

  Anchored Anchor(int view, const Eigen::Vector2d& x, const uint8_t* descriptor,
                  const std::vector<FeatureLink>& links) const;
  DepthEstimate Estimate(int view, const Eigen::Vector3d& ray,
                         const std::vector<FeatureLink>& links) const;
  std::vector<FeatureLink> SearchViews(int view, const Eigen::Vector3d& x_camera,
                                       const uint8_t* descriptor,
                                       const std::vector<FeatureLink>& links) const;
  std::vector<int> NearestViews(int view) const;
  std::vector<FeatureLink> SightingsOf(const Plane& plane, int feature) const;
  std::vector<FeatureLink> SightingsAt(int view, const Eigen::Vector2d& x) const;
  const uint8_t* DescriptorAt(int view, const Eigen::Vector2d& x) const;
  UncertainPoint PointOf(int view, const Anchored& one) const;
  PlacedFeature Combine(int view, const Anchored& one,
                        const std::optional<FittedPlane>& plane) const;

  const MapData& map_;
  const std::vector<PosedView>& views_;
  const PoseTracks& tracks_;
  const PoseOptions& options_;
  std::vector<KeypointGrid> grids_;
  std::vector<std::vector<int>> near_;  // of each view
  std::unordered_map<KeyframeId, int> view_of_;
};

}  // namespace waystone
