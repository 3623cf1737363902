// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <utility>
#include <vector>

#include "builder/planes/keyframe_sample.h"
#include "builder/poses/options.h"

namespace waystone {

// A keyframe of known pose and camera, with all its features. Refers to the map and the sample.
struct PosedView {
  const Keyframe* keyframe = nullptr;
  Camera camera;  // of the features: of the working image
  const Features* features = nullptr;
  Eigen::Isometry3d frame_from_camera = Eigen::Isometry3d::Identity();
  std::vector<Eigen::Vector3d> rays;  // unit, of each feature
  double sigma_rad = 0;               // of a ray
};

// The keyframes that have a pose, in the map's order. Throws MapError(kBadCamera) for one whose
// sequence has no camera, and kBadRequest where too few have a pose. Deterministic; thread-safe.
std::vector<PosedView> CollectPosedViews(const MapData& map,
                                         const std::vector<SampledKeyframe>& features,
                                         const GivenPoses& poses, const PoseOptions& options);

// Where a feature was found again: a view and a feature of it, by index.
struct FeatureLink {
  int view = 0;
  int feature = 0;
};

// Which features neighbouring views of a sequence share: matches that fit one epipolar geometry,
// independently of the poses. Refers to its arguments. Immutable after construction, and
// deterministic on any number of threads (it uses TBB's).
class PoseTracks {
 public:
  PoseTracks(const std::vector<PosedView>& views, const PoseOptions& options);

  const std::vector<FeatureLink>& LinksOf(int view, int feature) const {
    return links_[view][feature];
  }
  // The share of the matches that agree with these poses (frame_from_camera, one per view) within
  // `max_sigmas`, with the point ahead of both cameras. 1 without matches.
  double ConsistentShare(const std::vector<Eigen::Isometry3d>& frame_from_camera,
                         double max_sigmas) const;

 private:
  struct LinkedPair {
    int a = 0;
    int b = 0;
    std::vector<std::pair<int, int>> features;
  };
  void Link(const std::vector<LinkedPair>& pairs);

  const std::vector<PosedView>& views_;
  const PoseOptions& options_;
  std::vector<LinkedPair> pairs_;
  std::vector<std::vector<std::vector<FeatureLink>>> links_;  // of each view, of each feature
};

}  // namespace waystone
