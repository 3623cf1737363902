// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/joinable.h"

#include "builder/calibration/stored_keyframes.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/base/version.h"
#include "schema/layers/planes/index_features.h"

namespace waystone {

std::string Named(const MapData& map) { return "map '" + Printable(map.info.name) + "'"; }

void CheckLayersAreJoinable(const MapData& map) {
  const char* layer = map.poses         ? "poses"
                      : map.appearance  ? "an appearance layer"
                      : map.orientation ? "an orientation layer"
                                        : nullptr;
  if (layer == nullptr) return;
  throw MapError(ErrorCode::kBadRequest,
                 Named(map) + " has " + layer +
                     "; only maps of planes alone can be changed; build a new map of the sources");
}

void CompleteJoined(const BuildOptions& options, MapData& map) {
  map.info.program = std::string("waystone ") + kVersion;
  map.index = IndexFeatures(map);
  FeatureOptions features = options.features;
  features.type = map.info.feature_type;
  RecalibratePlaneLayer(map, features, options.calibration);
}

}  // namespace waystone
