// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/joinable.h"

#include <optional>
#include <set>
#include <utility>

#include "builder/calibration/stored_keyframes.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/base/version.h"
#include "schema/layers/names/place_names.h"
#include "schema/layers/planes/index_features.h"

namespace waystone {

std::string Named(const MapData& map) { return "map '" + Printable(map.info.name) + "'"; }

void CheckLayersAreJoinable(const MapData& map) {
  const char* layer = map.appearance    ? "an appearance layer"
                      : map.orientation ? "an orientation layer"
                                        : nullptr;
  if (layer == nullptr) return;
  throw MapError(ErrorCode::kBadRequest, Named(map) + " has " + layer +
                                             "; only maps of planes, with or without poses, can be "
                                             "changed; build a new map of the sources");
}

NamedBefore::NamedBefore(const MapData& map) {
  ids_.names = map.names;
  if (ids_.names.empty()) return;
  for (const Keyframe& keyframe : map.keyframes) ids_.keyframes.emplace_back().id = keyframe.id;
  for (const Plane& plane : map.planes) ids_.planes.emplace_back().id = plane.id;
}

std::vector<std::string> NamedBefore::KeepNames(MapData& map,
                                                const std::map<PlaneId, PlaneId>& fused) const {
  const auto ids_of = [&map](NamedKind kind) {
    const std::vector<int64_t> ids = IdsOf(map, kind);
    return std::set<int64_t>(ids.begin(), ids.end());
  };
  const std::set<int64_t> keyframes = ids_of(NamedKind::kKeyframes);
  const std::set<int64_t> planes = ids_of(NamedKind::kPlanes);
  const auto new_id = [&](NamedKind kind, int64_t id) -> std::optional<int64_t> {
    const auto into = fused.find({id});
    if (kind == NamedKind::kPlanes && into != fused.end()) return into->second.value;
    const std::set<int64_t>& left = kind == NamedKind::kPlanes ? planes : keyframes;
    return left.contains(id) ? std::optional(id) : std::nullopt;
  };
  RenumberedPlaces kept = RenumberPlaces(ids_, map, new_id);
  map.names = std::move(kept.places);
  return std::move(kept.lost);
}

void CompleteJoined(const BuildOptions& options, MapData& map) {
  map.info.program = std::string("waystone ") + kVersion;
  map.index = IndexFeatures(map);
  FeatureOptions features = options.features;
  features.type = map.info.feature_type;
  RecalibratePlaneLayer(map, features, options.calibration);
}

}  // namespace waystone
