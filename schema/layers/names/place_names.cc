// SPDX-License-Identifier: Apache-2.0
#include "schema/layers/names/place_names.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "core/base/check.h"
#include "core/base/text.h"
#include "schema/map_data.h"

namespace waystone {
namespace {

// Bytes of the UTF-8 character at the start of `text`; 0 where there is none (RFC 3629).
size_t Utf8Bytes(std::string_view text) {
  const auto byte = [text](size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return 1;
  const size_t size = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() < size) return 0;
  for (size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xC0U) != 0x80) return 0;
  }
  const bool overlong = (lead == 0xE0 && byte(1) < 0xA0) || (lead == 0xF0 && byte(1) < 0x90);
  const bool surrogate = lead == 0xED && byte(1) >= 0xA0;
  const bool beyond = lead == 0xF4 && byte(1) >= 0x90;
  return overlong || surrogate || beyond ? 0 : size;
}

bool IsUtf8(std::string_view text) {
  while (!text.empty()) {
    const size_t bytes = Utf8Bytes(text);
    if (bytes == 0) return false;
    text.remove_prefix(bytes);
  }
  return true;
}

bool LessPolygon(const NamedPolygon& a, const NamedPolygon& b) {
  return std::ranges::lexicographical_compare(
      a, b, [](const Eigen::Vector2d& p, const Eigen::Vector2d& q) {
        return std::pair(p.x(), p.y()) < std::pair(q.x(), q.y());
      });
}

std::vector<NamedRange> JoinRanges(std::vector<NamedRange> ranges) {
  std::ranges::sort(ranges);
  std::vector<NamedRange> joined;
  for (const NamedRange& range : ranges) {
    // Compares by subtraction, since `last + 1` could overflow.
    if (!joined.empty() && joined.back().kind == range.kind &&
        range.first - 1 <= joined.back().last) {
      joined.back().last = std::max(joined.back().last, range.last);
    } else {
      joined.push_back(range);
    }
  }
  return joined;
}

template <class Item>
std::vector<int64_t> IdsOfItems(const std::vector<Item>& items) {
  std::vector<int64_t> ids;
  ids.reserve(items.size());
  for (const Item& item : items) ids.push_back(item.id.value);
  return ids;
}

}  // namespace

std::string_view NameOf(NamedKind kind) {
  switch (kind) {
    case NamedKind::kKeyframes:
      return "keyframes";
    case NamedKind::kNodes:
      return "nodes";
    case NamedKind::kPlanes:
      return "planes";
  }
  WS_CHECK(false, "unknown kind of named things");
}

std::optional<std::string> FindNameProblem(std::string_view name) {
  if (name.empty()) return "is empty";
  if (name.size() > kMaxPlaceNameBytes) {
    return "has " + std::to_string(name.size()) + " bytes; at most " +
           std::to_string(kMaxPlaceNameBytes) + " are allowed";
  }
  if (!IsUtf8(name)) return "is not UTF-8";
  for (size_t i = 0; i < name.size(); ++i) {
    const size_t bytes = ControlBytes(name.substr(i));
    if (bytes > 0) {
      return "has the control character " + EscapeControl(name.substr(i, bytes)) +
             "; names are plain text on one line";
    }
  }
  if (Trimmed(name).size() != name.size()) return "begins or ends with a blank";
  return std::nullopt;
}

double AreaOf(const NamedPolygon& polygon) {
  double twice = 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    // Relative to the first corner, so that an area far from the origin keeps its precision.
    const Eigen::Vector2d a = polygon[i] - polygon[0];
    const Eigen::Vector2d b = polygon[(i + 1) % polygon.size()] - polygon[0];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return std::abs(twice) / 2;
}

std::optional<std::string> FindPolygonProblem(const NamedPolygon& polygon) {
  if (polygon.size() < 3) {
    return "has " + std::to_string(polygon.size()) + " corners; an area has 3 or more";
  }
  for (const Eigen::Vector2d& corner : polygon) {
    // NaN, too, isn't within the bound.
    if (!(corner.cwiseAbs().maxCoeff() <= kMaxNamedCoordinate) || !corner.allFinite()) {
      return "has a corner beyond 1e9";
    }
  }
  if (!(AreaOf(polygon) > 0)) return "has no area; its corners are on one line or cancel out";
  return std::nullopt;
}

bool Holds(const NamedPolygon& polygon, const Eigen::Vector2d& point) {
  bool inside = false;
  for (size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Eigen::Vector2d &a = polygon[i], &b = polygon[j];
    if ((a.y() > point.y()) == (b.y() > point.y())) continue;
    const double x = a.x() + (point.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
    if (point.x() < x) inside = !inside;
  }
  return inside;
}

std::vector<NamedPlace> Canonical(std::vector<NamedPlace> places) {
  std::map<std::string, NamedPlace> by_name;
  for (NamedPlace& place : places) {
    NamedPlace& joined = by_name[place.name];
    joined.ranges.insert(joined.ranges.end(), place.ranges.begin(), place.ranges.end());
    joined.polygons.insert(joined.polygons.end(), place.polygons.begin(), place.polygons.end());
  }
  std::vector<NamedPlace> canonical;
  for (auto& [name, place] : by_name) {
    if (place.ranges.empty() && place.polygons.empty()) continue;
    place.name = name;
    place.ranges = JoinRanges(std::move(place.ranges));
    std::ranges::sort(place.polygons, LessPolygon);
    // Not std::ranges::unique, whose subrange clang 14 doesn't read.
    place.polygons.erase(std::unique(place.polygons.begin(), place.polygons.end()),
                         place.polygons.end());
    canonical.push_back(std::move(place));
  }
  return canonical;
}

std::optional<std::string> FindBoundProblem(const std::vector<NamedPlace>& places) {
  size_t ranges = 0, corners = 0;
  for (const NamedPlace& place : places) {
    ranges += place.ranges.size();
    for (const NamedPolygon& polygon : place.polygons) corners += polygon.size();
  }
  if (ranges <= kMaxNamedRanges && corners <= kMaxNamedCorners) return std::nullopt;
  return "they have " + std::to_string(ranges) + " ranges and " + std::to_string(corners) +
         " corners; a map holds at most " + std::to_string(kMaxNamedRanges) + " and " +
         std::to_string(kMaxNamedCorners);
}

std::vector<int64_t> IdsOf(const MapData& map, NamedKind kind) {
  switch (kind) {
    case NamedKind::kKeyframes:
      return IdsOfItems(map.keyframes);
    case NamedKind::kNodes:
      return map.appearance ? IdsOfItems(map.appearance->nodes) : std::vector<int64_t>{};
    case NamedKind::kPlanes:
      return IdsOfItems(map.planes);
  }
  WS_CHECK(false, "unknown kind of named things");
}

std::vector<NamedRange> RangesOf(const MapData& map, NamedKind kind,
                                 const std::set<int64_t>& held) {
  std::vector<NamedRange> ranges;
  bool open = false;
  for (const int64_t id : IdsOf(map, kind)) {
    const bool within = held.contains(id);
    if (within && open) ranges.back().last = id;
    if (within && !open) ranges.push_back({kind, id, id});
    open = within;
  }
  return ranges;
}

RenumberedPlaces RenumberPlaces(const MapData& from, const MapData& to, const NewId& new_id) {
  RenumberedPlaces renumbered;
  for (const NamedPlace& place : from.names) {
    NamedPlace moved{place.name, {}, place.polygons};
    for (const NamedKind kind : {NamedKind::kKeyframes, NamedKind::kNodes, NamedKind::kPlanes}) {
      const std::vector<int64_t> old_ids = IdsOf(from, kind);
      std::set<int64_t> ids;
      for (const NamedRange& range : place.ranges) {
        if (range.kind != kind) continue;
        const auto last = std::ranges::upper_bound(old_ids, range.last);
        for (auto id = std::ranges::lower_bound(old_ids, range.first); id < last; ++id) {
          if (const std::optional<int64_t> now = new_id(kind, *id)) ids.insert(*now);
        }
      }
      const std::vector<NamedRange> ranges = RangesOf(to, kind, ids);
      moved.ranges.insert(moved.ranges.end(), ranges.begin(), ranges.end());
    }
    if (moved.ranges.empty() && moved.polygons.empty()) renumbered.lost.push_back(place.name);
    renumbered.places.push_back(std::move(moved));
  }
  renumbered.places = Canonical(std::move(renumbered.places));
  return renumbered;
}

}  // namespace waystone
