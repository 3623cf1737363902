// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "core/geometry/pose2.h"
#include "core/localization/graph_filter.h"
#include "localizer/appearance/appearance.h"

namespace waystone {

// What is known of a robot when a panorama of its series comes.
struct SeriesContext {
  FilterState previous;  // Answer::belief of the panorama before; empty for the first
  // The motion since then, previous_from_now in the layer's units, where it is known.
  std::optional<Pose2> odometry;
  // Answer::described of the panorama before, where the asker still has it: without odometry, it
  // tells a robot that stands still.
  std::optional<FourierSignature> described = {};
};

struct SeriesOptions {
  PanoramaQueryOptions query;
  // Chance that the robot was carried elsewhere between two images and what a state keeps; lengths
  // are overruled by those below.
  GraphFilterOptions filter;
  double position_spacings = 1;
  double step_spacings = 3;
  double max_log_odds = 4;
  double min_alone = 0.5;

  static constexpr auto Fields(const auto& use) {
    using Self = SeriesOptions;
    return use(
        OptionGroup{"query", &Self::query},
        OptionField{"position_spacings", &Self::position_spacings, Closed(0.01, 1000), "",
                    "The filter's position_sigma, in spacings of the map's nodes. More lets "
                    "neighbours share the belief."},
        OptionField{
            "step_spacings", &Self::step_spacings, Closed(0.01, 1000), "",
            "The filter's step_sigma without odometry, in spacings of the map's nodes. More "
            "lets the robot move farther between two images."},
        OptionField{"max_log_odds", &Self::max_log_odds, Closed(0.1, 100), "",
                    "Largest contribution of one image to a node's log odds, since consecutive "
                    "images are not independent evidence. Lower takes longer to decide."},
        OptionField{"min_alone", &Self::min_alone, Closed(0, 1), "",
                    "A panorama counts when its likeliest place has this probability if nothing "
                    "else were like it. Less lets panoramas of what isn't in the map move the "
                    "belief."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// The belief about where the robot is, after a panorama that was compared with these nodes
// (CompareQuery), from what was known before. Empty context: a robot that may be anywhere. Images
// of one place are no independent evidence: one that speaks for the place believed in counts by how
// far the robot has moved over the map's spacing, at most once.
// Thread-safe, deterministic. Throws MapError(kBadRequest) for a belief of another map.
FilterState BeliefAfter(const MapIndex& index, const std::vector<ComparedNode>& compared,
                        bool verified, const SeriesContext& context, const SeriesOptions& options);

// The next panorama of a series: what it looks like (CompareQuery) and where the robot was before
// (UpdateBelief), so that places that look alike are told apart as it moves. The probability is the
// belief's around the answer, and the deciding gate kSeries; Answer::belief is what the next one is
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
