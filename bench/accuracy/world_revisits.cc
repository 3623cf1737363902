// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/world_revisits.h"

#include <algorithm>
#include <cstdio>
#include <set>
#include <string>
#include <vector>

#include "schema/layers/planes/surfaces.h"

namespace waystone::bench {
namespace {

// Keyframes by index, both included.
struct Visit {
  int first = 0;
  int last = 0;
};

bool ShareIn(const SharedPlanes& shared, int plane, const Visit& early, const Visit& late) {
  for (int a = early.first; a <= early.last; ++a) {
    for (int b = late.first; b <= late.last; ++b) {
      if (shared[b][a].contains(plane)) return true;
    }
  }
  return false;
}

std::map<int, std::vector<Visit>> FindVisits(const SharedPlanes& shared) {
  std::map<int, std::vector<Visit>> visits;
  for (int k = 1; k < static_cast<int>(shared.size()); ++k) {
    for (const int plane : shared[k][k - 1]) {
      std::vector<Visit>& of_plane = visits[plane];
      if (of_plane.empty() || of_plane.back().last < k - 1) of_plane.push_back({k - 1, k});
      of_plane.back().last = k;
    }
  }
  return visits;
}

std::set<PlaneId> SeenIn(const MapData& map, const std::vector<const Plane*>& planes,
                         const Visit& visit) {
  std::set<PlaneId> seen;
  for (const Plane* plane : planes) {
    const bool in = std::ranges::any_of(plane->views, [&](const PlaneView& view) {
      return view.keyframe >= map.keyframes[visit.first].id &&
             view.keyframe <= map.keyframes[visit.last].id;
    });
    if (in) seen.insert(plane->id);
  }
  return seen;
}

long long Id(const MapData& map, int keyframe) { return map.keyframes[keyframe].id.value; }

std::string ListOf(const std::set<PlaneId>& planes) {
  std::string list;
  for (const PlaneId plane : planes) list += " " + std::to_string(plane.value);
  return list.empty() ? " none" : list;
}

// Whether the two visits are joined.
bool Judge(const std::set<PlaneId>& early, const std::set<PlaneId>& late,
           const std::map<PlaneId, PlaneId>& surface_of,
           const std::set<std::pair<PlaneId, PlaneId>>& edges, RevisitFigures& figures) {
  ++figures.seen_again;
  const auto any_with = [&](auto&& joins) {
    return std::ranges::any_of(early, [&](PlaneId a) {
      return std::ranges::any_of(late, [&](PlaneId b) { return joins(a, b); });
    });
  };
  if (early.empty() || late.empty()) {
    ++figures.no_plane;
    return false;
  }
  if (any_with([](PlaneId a, PlaneId b) { return a == b; })) {
    ++figures.one_plane;
  } else if (any_with([&](PlaneId a, PlaneId b) { return surface_of.at(a) == surface_of.at(b); })) {
    ++figures.one_surface;
  } else if (any_with([&](PlaneId a, PlaneId b) { return edges.contains(std::minmax(a, b)); })) {
    ++figures.joined_by_edge;
  } else {
    ++figures.apart;
    return false;
  }
  return true;
}

}  // namespace

RevisitFigures CountRevisits(const SharedPlanes& shared, const MapData& map,
                             const std::map<PlaneId, int>& owners) {
  std::set<std::pair<PlaneId, PlaneId>> edges;
  for (const Edge& edge : map.edges) edges.insert(std::minmax(edge.a, edge.b));
  const std::vector<PlaneId> surfaces = FindSurfaces(map.planes, map.edges);
  std::map<PlaneId, PlaneId> surface_of;
  for (size_t p = 0; p < surfaces.size(); ++p) surface_of[map.planes[p].id] = surfaces[p];
  std::map<int, std::vector<const Plane*>> planes_of;
  for (const Plane& plane : map.planes) {
    if (owners.contains(plane.id)) planes_of[owners.at(plane.id)].push_back(&plane);
  }
  RevisitFigures figures;
  for (const auto& [surface, visits] : FindVisits(shared)) {
    for (size_t late = 1; late < visits.size(); ++late) {
      for (size_t early = 0; early < late; ++early) {
        ++figures.pairs;
        if (!ShareIn(shared, surface, visits[early], visits[late])) {
          ++figures.too_few_matches;
          continue;
        }
        const std::set<PlaneId> before = SeenIn(map, planes_of[surface], visits[early]);
        const std::set<PlaneId> again = SeenIn(map, planes_of[surface], visits[late]);
        if (Judge(before, again, surface_of, edges, figures)) continue;
        std::printf(
            "apart: true plane %d in keyframes %lld to %lld and %lld to %lld, as planes%s and%s\n",
            surface, Id(map, visits[early].first), Id(map, visits[early].last),
            Id(map, visits[late].first), Id(map, visits[late].last), ListOf(before).c_str(),
            ListOf(again).c_str());
      }
    }
  }
  return figures;
}

}  // namespace waystone::bench
