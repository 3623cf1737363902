// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/joinable.h"

#include <optional>
#include <set>
#include <utility>

#include "builder/calibration/stored_keyframes.h"
#include "builder/calibration/stored_nodes.h"
#include "builder/options_record.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/base/version.h"
#include "core/camera/panorama.h"
#include "schema/layers/names/place_names.h"
#include "schema/layers/planes/index_features.h"

namespace waystone {

std::string Named(const MapData& map) { return "map '" + Printable(map.info.name) + "'"; }

namespace {

// How a layer's panoramas are described: "32 rows, 64 magnitudes and 64 phases".
std::string DescriptionOf(const SignatureOptions& described) {
  return std::to_string(described.rows) + " rows, " + std::to_string(described.k1) +
         " magnitudes and " + std::to_string(described.k2) + " phases" +
         (described.normalise ? "" : ", not normalised");
}

void CheckPanoramas(const MapData& first, const MapData& other) {
  const AppearanceLayer& a = *first.appearance;
  const AppearanceLayer& b = *other.appearance;
  const std::string maps = Named(first) + " and " + Named(other);
  if (DescriptionOf(a.described) != DescriptionOf(b.described)) {
    throw MapError(ErrorCode::kBadRequest,
                   maps + " describe panoramas by " + DescriptionOf(a.described) + ", and by " +
                       DescriptionOf(b.described) +
                       "; build them with the same appearance.describe.signature options");
  }
  if (!BandsAgree(a.described.band, b.described.band)) {
    throw MapError(ErrorCode::kBadRequest,
                   maps +
                       " have panoramas that show different elevations; build one of them with "
                       "the band of the other (appearance.describe.signature.band)");
  }
  if (a.mirror && b.mirror && !(a.mirror == b.mirror)) {
    throw MapError(ErrorCode::kBadRequest,
                   maps +
                       " have images of different mirrors, and a map unwraps those of one; "
                       "unwrap one walk (waystone unwrap) and build its map of the panoramas");
  }
}

}  // namespace

void CheckLayersAreJoinable(const std::vector<MapData>& maps) {
  const MapData* first = nullptr;
  for (const MapData& map : maps) {
    if (!map.appearance) continue;
    if (first == nullptr) first = &map;
    CheckPanoramas(*first, map);
  }
}

BuildOptions OptionsOfMap(const MapData& map) {
  BuildOptions options = OptionsOfRecord(map.info.options_json);
  options.features.type = map.info.feature_type;
  if (!map.appearance) return options;
  options.appearance.describe.signature = map.appearance->described;
  if (!map.appearance->mirror) return options;
  const LayerMirror& mirror = *map.appearance->mirror;
  PanoramaOptions& panorama = options.appearance.describe.panorama;
  panorama.columns = mirror.columns;
  panorama.mirror_band = mirror.band;
  panorama.mirror = mirror.ring;
  panorama.mirror_clockwise = mirror.clockwise;
  return options;
}

void CheckOptionsFit(const MapData& map, const BuildOptions& options) {
  if (options.features.type != map.info.feature_type) {
    throw MapError(ErrorCode::kBadRequest, Named(map) + " has " +
                                               std::string(NameOf(map.info.feature_type)) +
                                               " features; leave features.type as it is");
  }
  if (!map.appearance) return;
  const std::string described = DescriptionOf(map.appearance->described);
  if (DescriptionOf(options.appearance.describe.signature) == described) return;
  throw MapError(ErrorCode::kBadRequest,
                 Named(map) + " describes panoramas by " + described +
                     "; leave the appearance.describe.signature options as they are");
}

NamedBefore::NamedBefore(const MapData& map) {
  ids_.names = map.names;
  if (ids_.names.empty()) return;
  if (map.appearance) {
    ids_.appearance.emplace();
    for (const AppearanceNode& node : map.appearance->nodes) {
      ids_.appearance->nodes.emplace_back().id = node.id;
    }
  }
  for (const Keyframe& keyframe : map.keyframes) ids_.keyframes.emplace_back().id = keyframe.id;
  for (const Plane& plane : map.planes) ids_.planes.emplace_back().id = plane.id;
}

std::vector<std::string> NamedBefore::KeepNames(MapData& map,
                                                const std::map<PlaneId, PlaneId>& fused) const {
  std::map<NamedKind, std::set<int64_t>> left;
  for (const NamedKind kind : {NamedKind::kKeyframes, NamedKind::kNodes, NamedKind::kPlanes}) {
    const std::vector<int64_t> ids = IdsOf(map, kind);
    left[kind] = {ids.begin(), ids.end()};
  }
  const auto new_id = [&](NamedKind kind, int64_t id) -> std::optional<int64_t> {
    const auto into = fused.find({id});
    if (kind == NamedKind::kPlanes && into != fused.end()) return into->second.value;
    return left.at(kind).contains(id) ? std::optional(id) : std::nullopt;
  };
  RenumberedPlaces kept = RenumberPlaces(ids_, map, new_id);
  map.names = std::move(kept.places);
  return std::move(kept.lost);
}

void CompleteJoined(const BuildOptions& options, const ChangedLayers& changed, MapData& map) {
  map.info.program = std::string("waystone ") + kVersion;
  map.index = IndexFeatures(map);
  if (map.keyframes.empty()) {
    map.verdict.reset();
  } else if (changed.planes) {
    FeatureOptions features = options.features;
    features.type = map.info.feature_type;
    RecalibratePlaneLayer(map, features, options.calibration);
  }
  if (map.appearance && changed.appearance) {
    RecalibrateAppearanceLayer(map, options.appearance_calibration);
  }
}

}  // namespace waystone
