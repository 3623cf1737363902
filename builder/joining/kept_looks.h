// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <vector>

#include "schema/map_data.h"

namespace waystone {

// What was looked for of a map's features before some of them are fused or go. Features are known
// again by their descriptors, which stay as they are wherever a feature is moved to.
class LooksBefore {
 public:
  explicit LooksBefore(const MapData& map);

  // Leaves what was counted of the features and sequences that the map still has; planes that were
  // fused are what they have become. Nothing is known of features that came from elsewhere.
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
