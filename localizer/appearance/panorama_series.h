// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "core/localization/graph_filter.h"
#include "localizer/appearance/appearance.h"

namespace waystone {

struct SeriesOptions {
  PanoramaQueryOptions query;
  // Chance that the robot was carried elsewhere between two images and what a state keeps; lengths
  // are overruled by those below.
  GraphFilterOptions filter;
  // The filter's position_deviation and, without odometry, step_deviation, in spacings of the map's
  // nodes, 0.01 to 1000.
  double position_spacings = 1;
  double step_spacings = 3;
  // An image's log odds for a node count at most so much, 0.1 to 100: what looks alike in one image
  // does in the next, so that images are no independent evidence. Less takes longer to decide.
  double max_log_odds = 4;
  // A panorama counts when its likeliest place has this probability if nothing else were like it,
  // 0 to 1. Less lets panoramas of what isn't in the map move the belief.
  double min_alone = 0.5;

  void Check() const;  // throws MapError(kBadOptions)
};

// The belief about where the robot is, after a panorama that was compared with these nodes
// (CompareQuery), from what was known before. Empty context: a robot that may be anywhere.
// Thread-safe, deterministic. Throws MapError(kBadRequest) for a belief of another map.
FilterState BeliefAfter(const MapIndex& index, const std::vector<ComparedNode>& compared,
                        bool verified, const SeriesContext& context, const SeriesOptions& options);

// The next panorama of a series: what it looks like (CompareQuery) and where the robot was before
// (UpdateBelief), so that places that look alike are told apart as it moves. The probability is the
// belief's around the answer, and `decided_by` is "series"; Answer::belief is what the next one is
// asked with. A panorama that looks like no place of the map is answered so and leaves the belief
// as it was. Thread-safe, deterministic. Throws MapError(kBadOptions), and kBadRequest for a belief
// of another map.
Answer ContinueSeries(const MapIndex& index, const PanoramaQuery& query,
                      const SeriesContext& context, const SeriesOptions& options = {});

// The same for an image, with times; nothing is thrown for a bad panorama: the verdict is
// kBadImage, and the belief stays.
Answer LocalizeInSeries(const MapIndex& index, const cv::Mat& grey, const SeriesContext& context,
                        const SeriesOptions& options = {});

}  // namespace waystone
