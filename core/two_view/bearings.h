// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "core/camera/rig.h"
#include "core/features/features.h"
#include "core/features/match.h"

namespace waystone {

struct BearingFeatureOptions {
  // The detector of each image; SIFT by default (sec. III-C).
  FeatureOptions features{.max_features = 1500};
  // Each image is divided into this many cells along its longer side, 1 to 64, of which each keeps
  // as many of its strongest features as the cells share: features spread over the whole view
  // (the bucketing of sec. III-C) instead of crowding on what is best textured.
  int buckets = 8;
  // Features kept per image, 10 to 100,000. More give more matches and cost time with their square.
  int max_kept = 500;

  void Check() const;  // throws MapError(kBadOptions)
};

// Features of all images of a rig: the unit ray of each in the rig's frame, and its descriptor.
struct BearingFeatures {
  FeatureType type = FeatureType::kSift;
  std::vector<Eigen::Vector3d> rays;
  std::vector<int> camera;  // index in the rig
  std::vector<Keypoint> keypoints;
  Descriptors descriptors;

  int size() const { return static_cast<int>(rays.size()); }
};

// Features of the images of a rig, one 8-bit grey image a camera; an empty image gives none. The
// rig is taken to have one centre: the cameras' places are ignored. Throws MapError(kBadImage) for
// an image whose size isn't its camera's. Deterministic; thread-safe.
BearingFeatures ExtractBearings(const Rig& rig, std::span<const cv::Mat> images,
                                const BearingFeatureOptions& options = {});

// Rays of two rigs that see the same points: row i of each belongs together.
struct MatchedRays {
  std::vector<Eigen::Vector3d> a;
  std::vector<Eigen::Vector3d> b;
  std::vector<Match> matches;  // rows of the features they come from

  int size() const { return static_cast<int>(a.size()); }
};

MatchedRays MatchBearings(const BearingFeatures& a, const BearingFeatures& b,
                          const MatchOptions& options = {});

}  // namespace waystone
