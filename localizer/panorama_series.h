// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "core/localization/graph_filter.h"
#include "localizer/appearance.h"

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

  void Check() const;  // throws MapError(kBadOptions)
};

struct SeriesStep {
  Answer answer;
  // What the next panorama is asked with; empty as long as none looked like a place of the map.
  FilterState state;
};

// The next panorama of a series: what it looks like (LocatePanorama) and where the robot was before
// (UpdateBelief), so that places that look alike are told apart as it moves. `odometry` is
// previous_from_now in the layer's units. The probability is the belief's around the answer, and
// `decided_by` is "series"; a panorama that looks like no place of the map is answered so and
// leaves the state as it was. Thread-safe, deterministic. Throws MapError(kBadOptions), and
// kBadRequest for a state of another map.
SeriesStep ContinueSeries(const MapIndex& index, const PanoramaQuery& query,
                          const FilterState& previous, const std::optional<Pose2>& odometry,
                          const SeriesOptions& options = {});

}  // namespace waystone
