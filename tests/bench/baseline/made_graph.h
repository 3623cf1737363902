// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "bench/baseline/image_graph.h"
#include "core/base/random.h"
#include "core/homography/homography.h"

namespace waystone::bench {

inline Keypoint At(const Eigen::Vector2d& x) {
  return {static_cast<float>(x.x()), static_cast<float>(x.y()), 4.0f, 0.5f};
}

inline void AppendRandomRow(Descriptors& descriptors, Random& random) {
  std::vector<uint8_t> row(128);
  for (uint8_t& byte : row) byte = static_cast<uint8_t>(random.Below(60));
  descriptors.Append(row.data());
}

// An image of `count` features with random places and descriptors.
inline Features MadeImage(int count, uint64_t seed) {
  Random random(seed);
  Features features;
  features.width = 640;
  features.height = 480;
  features.descriptors = Descriptors(128);
  for (int i = 0; i < count; ++i) {
    features.keypoints.push_back(At({random.Uniform(20, 620), random.Uniform(20, 460)}));
    AppendRandomRow(features.descriptors, random);
  }
  return features;
}

// What another camera sees of the same plane: the first `shared` features moved by a homography,
// the rest new.
inline Features Seen(const Features& image, const Eigen::Matrix3d& h, int shared, uint64_t seed) {
  Features seen = MadeImage(image.size() - shared, seed);
  for (int i = 0; i < shared; ++i) {
    const Keypoint& k = image.keypoints[i];
    seen.keypoints.push_back(At(Apply(h, {k.x_px, k.y_px})));
    seen.descriptors.Append(image.descriptors.row(i));
  }
  return seen;
}

inline Eigen::Matrix3d MadeHomography() {
  Eigen::Matrix3d h;
  h << 0.95, 0.04, 12, -0.03, 1.02, -7, 2e-5, -1e-5, 1;
  return h;
}

// Three images: 1 and 2 share 80 features, 1 and 3 share none, 2 and 3 none.
inline std::vector<ImageNode> MadeNodes() {
  const Features first = MadeImage(200, 1);
  return {{KeyframeId{1}, 0, first},
          {KeyframeId{2}, 10, Seen(first, MadeHomography(), 80, 2)},
          {KeyframeId{3}, 20, MadeImage(200, 3)}};
}

}  // namespace waystone::bench
