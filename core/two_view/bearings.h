// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "core/base/options.h"
#include "core/camera/rig.h"
#include "core/features/features.h"
#include "core/features/match.h"

namespace waystone {

struct BearingFeatureOptions {
  FeatureOptions features{.max_features = 1500, .contrast_threshold = 0.02};
  int buckets = 8;
  int max_kept = 500;

  static constexpr auto Fields(const auto& use) {
    return use(OptionGroup{"features", &BearingFeatureOptions::features},
               OptionField{"buckets", &BearingFeatureOptions::buckets, Closed(1, 64), "",
                           "Each image is divided into cells, this many along its longer side, and "
                           "each cell keeps its share of the strongest features, so that they are "
                           "spread over the image (bucketing, sec. III-C)."},
               OptionField{"max_kept", &BearingFeatureOptions::max_kept, Closed(10, 100'000), "",
                           "Maximum number of features per image. More features give more matches; "
                           "time grows quadratically."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// Features of all images of a rig: the unit ray of each in the rig's frame, and its descriptor.
struct BearingFeatures {
  FeatureType type = FeatureType::kSift;
  std::vector<Eigen::Vector3d> rays;
  std::vector<int> camera;          // index in the rig
  std::vector<Keypoint> keypoints;  // in px of the working images (Features)
  Descriptors descriptors;

  int size() const { return static_cast<int>(rays.size()); }
};

// Features of the images of a rig, one 8-bit grey image per camera; an empty image gives none. The
// rig is assumed to have one centre: the cameras' positions are ignored. Throws MapError(kBadImage)
// for an image whose size isn't its camera's. Deterministic; thread-safe.
BearingFeatures ExtractBearings(const Rig& rig, std::span<const cv::Mat> images,
                                const BearingFeatureOptions& options = {});

// Rays of two rigs that see the same points: rows i belong together.
struct MatchedRays {
  std::vector<Eigen::Vector3d> a;
  std::vector<Eigen::Vector3d> b;
  std::vector<Match> matches;  // by rows of the features

  int size() const { return static_cast<int>(a.size()); }
};

MatchedRays MatchBearings(const BearingFeatures& a, const BearingFeatures& b,
                          const MatchOptions& options = {});

}  // namespace waystone
