// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "core/features/features.h"

namespace waystone::bench {

// The image that a query was found in.
struct FoundImage {
  int image = 0;
  int inliers = 0;
};

// Plain image search to measure against: every query is matched with every image (nearest by ratio
// 0.8, mutual and one to one) and found in the one with the most inliers of a fundamental matrix
// (MAGSAC, 1.5 px), if there are at least 15.
class ImageSearch {
 public:
  // Keeps the `kept` most repeatable features of each image: those that match, consistently with
  // the epipolar geometry, in as many as possible of the two images before and the two after.
  ImageSearch(std::vector<Features> images, int kept);

  std::optional<FoundImage> Find(const Features& query) const;
  int64_t CountFeatures() const;

 private:
  std::vector<Features> images_;
};

}  // namespace waystone::bench
