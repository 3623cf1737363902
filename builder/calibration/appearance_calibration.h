// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "builder/appearance/appearance_layer.h"
#include "localizer/appearance/appearance.h"

namespace waystone {

struct AppearanceCalibrationOptions {
  // Panoramas that are asked for again, spread evenly over the layer, 1 to 100,000. More tell the
  // model better, and cost a query for each of the surroundings below.
  int max_nodes = 60;
  // An answer within so many spacings of the truth is right, 0.1 to 100.
  double right_spacings = 2;
  // Each panorama is asked for as if its surroundings weren't in the map: without the nodes within
  // so many spacings, 0 (itself alone) to 1000. Just beyond right_spacings answers are wrong by
  // little: that is what the model has to learn to refuse.
  std::vector<double> blank_spacings = {0, 2, 3, 6};
  // Panoramas of a made building that are asked for too, 0 to 1000: what isn't in the map. They
  // cost about 50 ms each.
  int rendered_negatives = 12;
  PanoramaQueryOptions query;
  AppearanceFitOptions fit;

  void Check() const;  // throws MapError(kBadOptions)
};

// A panorama of which the truth is known.
struct AppearanceCalibrationQuery {
  PanoramaQuery query;
  Pose2 truth;    // in the layer's frame
  int node = -1;  // the layer's node that it is; -1 where it was left out as redundant
};

// The model of one kind of answers, verified by features or by appearance alone as the queries ask
// for, fitted to answers of the map itself: each query is asked for without the nodes around it, by
// the options' radii, where the answer is right or wrong by its distance. `outside` are panoramas
// of what the map doesn't show. Samples of the other kind are left out. `before_each`, where given,
// is called before each query, from any thread and by several at a time; what it throws ends the
// fit. Throws MapError(kBadOptions); the map has an appearance layer (WS_CHECK). Deterministic on
// any number of threads.
AppearanceVerdict CalibrateAppearance(const MapIndex& index,
                                      const std::vector<AppearanceCalibrationQuery>& queries,
                                      const std::vector<PanoramaQuery>& outside, bool verified,
                                      const AppearanceCalibrationOptions& options = {},
                                      const std::function<void()>& before_each = {});

// Fits the models of the map's appearance layer, of answers by appearance alone and, where the
// nodes keep features, of verified ones, to `samples` and to rendered negatives. Reports the
// stage "calibration".
void CalibrateAppearanceLayer(MapData& map, const std::vector<AppearanceSampleFrame>& samples,
                              const AppearanceCalibrationOptions& options,
                              ProgressReporter& progress);

// A node as a query: its own signature, and its features where the options verify.
PanoramaQuery QueryOfNode(const MapIndex& index, int node, const PanoramaQueryOptions& options);

// The nodes themselves as such queries, at most `max_nodes`, spread evenly.
std::vector<AppearanceCalibrationQuery> QueriesOfNodes(const MapIndex& index, int max_nodes,
                                                       const PanoramaQueryOptions& options);

}  // namespace waystone
