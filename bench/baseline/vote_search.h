// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "bench/baseline/image_search.h"
#include "core/search/search_index.h"

namespace waystone::bench {

// Image search as in a short program, to measure against: every feature of a query votes for the
// image of its nearest feature, the five images with the most votes are matched with the query
// (nearest by ratio 0.8, mutual and one to one), and it is found in the one with the most inliers
// of a homography (OpenCV's MAGSAC, 3 px), if there are at least 15.
class VoteSearch {
 public:
  // Images of one feature type. Votes are exact with `probes` 0; otherwise they are found through
  // lists like a map's, `probes` of them for each feature.
  VoteSearch(std::vector<Features> images, int probes);

  std::optional<FoundImage> Find(const Features& query) const;
  // Of descriptors and positions (two bytes per coordinate), without any search structure.
  int64_t CountBytes() const;

 private:
  std::vector<int> MostVoted(const Features& query) const;

  std::vector<Features> images_;
  std::vector<int> image_of_row_;
  SearchIndex index_;
  int probes_;
};

}  // namespace waystone::bench
