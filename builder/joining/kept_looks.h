// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <vector>

#include "schema/map_data.h"

namespace waystone {

// What was looked for of a map's features before some of them are fused or removed. Features are
// identified by their descriptors, which stay the same wherever a feature is moved. Immutable after
// construction.
class LooksBefore {
 public:
  explicit LooksBefore(const MapData& map);

  // Restores the counts of the features and sequences that the map still has; fused planes count as
  // the ones that they were fused into. Features that came from elsewhere have no counts.
  void KeepLooks(MapData& map, const std::map<PlaneId, PlaneId>& fused = {}) const;

 private:
  // Features of a plane or a keyframe with what each sequence found of them.
  struct Counted {
    Descriptors descriptors;
    std::map<SequenceId, std::vector<FeatureLooks>> looks;
  };
  using Rows = std::map<SequenceId, std::vector<FeatureLooks>>;

  static Rows Carried(const std::vector<const Counted*>& from, const Descriptors& to,
                      const MapData& map);

  std::map<PlaneId, Counted> planes_;
  std::map<KeyframeId, Counted> landmarks_;
};

}  // namespace waystone
