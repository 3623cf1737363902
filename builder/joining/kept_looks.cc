// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/kept_looks.h"

#include <algorithm>
#include <deque>
#include <string>
#include <utility>

namespace waystone {
namespace {

std::string KeyOf(const Descriptors& descriptors, int row) {
  const uint8_t* first = descriptors.row(row);
  return {first, first + descriptors.bytes()};
}

bool HasSequence(const MapData& map, SequenceId id) {
  return std::ranges::binary_search(map.sequences, id, {}, &Sequence::id);
}

bool IsCounted(const std::vector<FeatureLooks>& looks) {
  return std::ranges::any_of(looks, [](const FeatureLooks& one) { return one.looked > 0; });
}

}  // namespace

LooksBefore::LooksBefore(const MapData& map) {
  for (const PlaneLooks& row : map.looks.planes) {
    Counted& counted = planes_[row.plane];
    counted.looks[row.sequence] = row.features;
    if (counted.descriptors.rows() > 0) continue;
    counted.descriptors =
        std::ranges::lower_bound(map.planes, row.plane, {}, &Plane::id)->descriptors;
  }
  for (const LandmarkLooks& row : map.looks.landmarks) {
    Counted& counted = landmarks_[row.keyframe];
    counted.looks[row.sequence] = row.landmarks;
    if (counted.descriptors.rows() > 0) continue;
    counted.descriptors =
        std::ranges::lower_bound(map.keyframes, row.keyframe, {}, &Keyframe::id)->landmarks.codes;
  }
}

// Features of the same descriptor follow each other as they did.
LooksBefore::Rows LooksBefore::Carried(const std::vector<const Counted*>& from,
                                       const Descriptors& to, const MapData& map) {
  Rows rows;
  for (const Counted* counted : from) {
    std::map<std::string, std::deque<int>> places;
    for (int f = 0; f < to.rows(); ++f) places[KeyOf(to, f)].push_back(f);
    std::vector<int> place_of(static_cast<size_t>(counted->descriptors.rows()), -1);
    for (int f = 0; f < counted->descriptors.rows(); ++f) {
      const auto found = places.find(KeyOf(counted->descriptors, f));
      if (found == places.end() || found->second.empty()) continue;
      place_of[static_cast<size_t>(f)] = found->second.front();
      found->second.pop_front();
    }
    for (const auto& [sequence, looks] : counted->looks) {
      if (!HasSequence(map, sequence)) continue;
      std::vector<FeatureLooks>& row = rows[sequence];
      row.resize(static_cast<size_t>(to.rows()));
      for (size_t f = 0; f < looks.size(); ++f) {
        if (place_of[f] >= 0) row[static_cast<size_t>(place_of[f])] = looks[f];
      }
    }
  }
  std::erase_if(rows, [](const auto& row) { return !IsCounted(row.second); });
  return rows;
}

void LooksBefore::KeepLooks(MapData& map, const std::map<PlaneId, PlaneId>& fused) const {
  std::map<PlaneId, std::vector<const Counted*>> now;
  for (const auto& [id, counted] : planes_) {
    const auto into = fused.find(id);
    now[into == fused.end() ? id : into->second].push_back(&counted);
  }
  Looks kept;
  for (const Plane& plane : map.planes) {
    const auto from = now.find(plane.id);
    if (from == now.end()) continue;
    for (auto& [sequence, looks] : Carried(from->second, plane.descriptors, map)) {
      kept.planes.push_back({plane.id, sequence, looks});
    }
  }
  for (const Keyframe& keyframe : map.keyframes) {
    const auto from = landmarks_.find(keyframe.id);
    if (from == landmarks_.end()) continue;
    for (auto& [sequence, looks] : Carried({&from->second}, keyframe.landmarks.codes, map)) {
      kept.landmarks.push_back({keyframe.id, sequence, looks});
    }
  }
  map.looks = std::move(kept);
}

}  // namespace waystone
