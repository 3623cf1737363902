// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/merge_maps.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <utility>

#include "builder/joining/append_map.h"
#include "builder/joining/joinable.h"
#include "builder/planes/fusion.h"
#include "builder/planes/plane_features.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "schema/sessions.h"

namespace waystone {
namespace {

// Which of the joined maps each plane is from, by the first plane of each: planes of one map follow
// each other.
class MapOfPlane {
 public:
  void StartMap(PlaneId first) { firsts_.push_back(first); }
  bool AreApart(PlaneId a, PlaneId b) const { return NumberOf(a) != NumberOf(b); }

 private:
  std::ptrdiff_t NumberOf(PlaneId id) const {
    return std::ranges::upper_bound(firsts_, id) - firsts_.begin();
  }

  std::vector<PlaneId> firsts_;
};

void CheckJoinable(const std::vector<MapData>& maps) {
  if (maps.size() < 2) {
    throw MapError(ErrorCode::kBadRequest,
                   std::to_string(maps.size()) + " map given; joining takes two or more");
  }
  const FeatureType type = maps.front().info.feature_type;
  std::map<std::string, std::string> named;  // sessions by their versions: the map they came in
  for (const MapData& map : maps) {
    CheckLayersAreJoinable(map);
    if (map.info.feature_type != type) {
      throw MapError(ErrorCode::kBadRequest,
                     Named(maps.front()) + " has " + std::string(NameOf(type)) + " features and " +
                         Named(map) + " has " + std::string(NameOf(map.info.feature_type)) +
                         "; build them with the same --features");
    }
    for (const MapSession& session : SessionsOf(map)) {
      if (session.version.empty()) continue;
      const auto [known, added] = named.emplace(session.version, Named(map));
      if (added) continue;
      throw MapError(ErrorCode::kBadRequest, "session '" + Printable(session.name) + "' is in " +
                                                 known->second + " and again in " + Named(map) +
                                                 "; give each session once");
    }
  }
}

// Fuses planes of different maps, and counts what it does.
void Fuse(const MapOfPlane& origin, const PlaneLayerOptions& options, MapData& map,
          JoinReport& report) {
  std::vector<FusionCandidate> pairs =
      ProposeFusions(map.planes, map.edges, map.info.feature_type, options.fusion);
  std::erase_if(pairs,
                [&](const FusionCandidate& pair) { return !origin.AreApart(pair.m, pair.n); });
  std::map<PlaneId, size_t> feature_count;
  for (const Plane& plane : map.planes) feature_count[plane.id] = plane.features.size();
  const NamedBefore named(map);
  FusionResult fused = FusePairs(std::move(map.planes), std::move(map.edges), map.keyframes, pairs,
                                 map.info.feature_type, options);
  map.planes = std::move(fused.planes);
  map.edges = std::move(fused.edges);
  named.KeepNames(map, fused.merged_into);
  report.planes_fused = fused.fused;
  report.surfaces_joined = fused.joined;
  for (Plane& plane : map.planes) {
    if (plane.features.size() == feature_count.at(plane.id)) continue;
    DropSparseFeatures(options.plenty_of_features, options.votes_in_plenty, plane);
    plane.outline = ComputeOutline(plane.features);
  }
}

// One after the other.
JoinResult Join(std::vector<MapData> maps, const std::string& name, const BuildOptions& options) {
  JoinResult result;
  result.map = std::move(maps.front());
  MapOfPlane origin;
  for (size_t i = 1; i < maps.size(); ++i) {
    const size_t planes = result.map.planes.size();
    AppendMap(std::move(maps[i]), result.map);
    if (planes < result.map.planes.size()) origin.StartMap(result.map.planes[planes].id);
  }
  result.map.info.name = name;
  Fuse(origin, options.planes, result.map, result.report);
  CompleteJoined(options, result.map);
  result.report.sessions = static_cast<int>(SessionsOf(result.map).size());
  return result;
}

}  // namespace

JoinResult MergeMaps(std::vector<MapData> maps, const std::string& name,
                     const BuildOptions& options) {
  options.Check();
  CheckJoinable(maps);
  std::ranges::stable_sort(maps, {}, [](const MapData& map) { return map.info.version; });
  return Join(std::move(maps), name, options);
}

JoinResult AddToMap(MapData map, MapData added, const BuildOptions& options) {
  options.Check();
  const std::string name = map.info.name;
  std::vector<MapData> maps;
  maps.push_back(std::move(map));
  maps.push_back(std::move(added));
  CheckJoinable(maps);
  return Join(std::move(maps), name, options);
}

}  // namespace waystone
