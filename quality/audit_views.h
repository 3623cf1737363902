// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "quality/audit.h"

// The features by which each keyframe could be recognised: internal to quality. All functions are
// pure; thread-safe.
namespace waystone {

struct KeyframeView {
  KeyframeId keyframe;
  std::vector<PlaneId> planes;  // that it saw, by id
  int features = 0;             // of these planes, in its image
};

// One for each keyframe, in the map's order.
std::vector<KeyframeView> CollectViews(const MapData& map);

// Features in view at a keyframe; 0 for one that isn't there.
int FeaturesInView(const std::vector<KeyframeView>& views, KeyframeId keyframe);

// Runs of keyframes at which a query may not be recognised.
std::vector<WeakRun> FindWeakRuns(const MapData& map, const std::vector<KeyframeView>& views,
                                  const AuditOptions& options);

}  // namespace waystone
