// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <compare>
#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

// Places of a map that people have named. FORMAT.md says how they are stored. All functions are
// pure; thread-safe.
namespace waystone {

struct MapData;

// What an id of a named place belongs to. The values are written into map files: never change them.
enum class NamedKind { kKeyframes = 0, kNodes = 1, kPlanes = 2 };
std::string_view NameOf(NamedKind kind);  // "keyframes", "nodes", "planes"

// All rows of a map from one id to another, both included and both in the map.
struct NamedRange {
  NamedKind kind = NamedKind::kKeyframes;
  int64_t first = 0;
  int64_t last = 0;

  auto operator<=>(const NamedRange&) const = default;
};

// An area of the map as seen from above: corners in order, in the frame and unit of the pose layer
// (as HorizontalOf lays it out, schema/layers/poses/horizontal.h) or, on maps without one, of the
// appearance layer.
using NamedPolygon = std::vector<Eigen::Vector2d>;

// A place consists of everything in its ranges and polygons.
struct NamedPlace {
  std::string name;
  std::vector<NamedRange> ranges;
  std::vector<NamedPolygon> polygons;

  bool operator==(const NamedPlace&) const = default;
};

// Limits on the named places of a map.
inline constexpr size_t kMaxPlaceNameBytes = 200;
inline constexpr size_t kMaxNamedRanges = 4000;     // of all places
inline constexpr size_t kMaxNamedCorners = 4000;    // of all polygons
inline constexpr double kMaxNamedCoordinate = 1e9;  // of a corner, absolute

// Why a text can't be a name: it is empty, too long, not UTF-8, begins or ends with a blank, or has
// characters that control a terminal. Nothing for a valid name.
std::optional<std::string> FindNameProblem(std::string_view name);

// Why a polygon can't be an area: fewer than three corners, coordinates that aren't finite or are
// too large, or no area. Nothing for a valid polygon.
std::optional<std::string> FindPolygonProblem(const NamedPolygon& polygon);

double AreaOf(const NamedPolygon& polygon);
// Whether a point is inside, by the even-odd rule; points on the border may count either way.
bool Holds(const NamedPolygon& polygon, const Eigen::Vector2d& point);

// The canonical form of places: those with the same name merged, ordered by name; ranges that
// overlap or touch joined, in order; polygons in order, each once; without empty places.
std::vector<NamedPlace> Canonical(std::vector<NamedPlace> places);

// Why a map can't hold that many; nothing where it can.
std::optional<std::string> FindBoundProblem(const std::vector<NamedPlace>& places);

// The ids of a kind that a map has, ascending.
std::vector<int64_t> IdsOf(const MapData& map, NamedKind kind);

// Some ids of a kind (`held`) as ranges that contain none of its other ids.
std::vector<NamedRange> RangesOf(const MapData& map, NamedKind kind, const std::set<int64_t>& held);

// The new id of what had `id`; nothing for what no longer exists.
using NewId = std::function<std::optional<int64_t>(NamedKind kind, int64_t id)>;

// Places after a change of their map.
struct RenumberedPlaces {
  std::vector<NamedPlace> places;  // canonical
  std::vector<std::string> lost;   // names of places of which nothing is left
};

// The places of `from` in `to`, a map with other ids for the same things, or without some of them.
// A range contains in `to` what it contained in `from`; where other rows of `to` lie between, it is
// split. Polygons stay: for a map in another frame, remove them first.
RenumberedPlaces RenumberPlaces(const MapData& from, const MapData& to, const NewId& new_id);

}  // namespace waystone
