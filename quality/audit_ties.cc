// SPDX-License-Identifier: Apache-2.0
#include "quality/audit_ties.h"

#include <algorithm>
#include <optional>
#include <set>

namespace waystone {
namespace {

// Keyframes in a row, of one stretch, that saw a plane.
struct Visit {
  KeyframeId best;           // with the most inliers
  int inliers = 0;           // of that one
  int last = 0;              // index in the map's keyframes
  std::set<PlaneId> others;  // planes that they saw besides
};

int FindIndex(const std::vector<KeyframeView>& views, KeyframeId keyframe) {
  const auto found =
      std::lower_bound(views.begin(), views.end(), keyframe,
                       [](const KeyframeView& view, KeyframeId id) { return view.keyframe < id; });
  return static_cast<int>(found - views.begin());
}

std::vector<Visit> FindVisits(const MapIndex& index, const Plane& plane,
                              const std::vector<KeyframeView>& views) {
  const std::vector<Keyframe>& keyframes = index.map().keyframes;
  std::vector<Visit> visits;
  for (const PlaneView& view : plane.views) {
    const int k = FindIndex(views, view.keyframe);
    const bool goes_on = !visits.empty() && visits.back().last + 1 == k &&
                         keyframes[k].sequence == keyframes[k - 1].sequence &&
                         keyframes[k].stretch == keyframes[k - 1].stretch;
    Visit& visit = goes_on ? visits.back() : visits.emplace_back();
    visit.last = k;
    if (view.inliers >= visit.inliers) {
      visit.best = view.keyframe;
      visit.inliers = view.inliers;
    }
    visit.others.insert(views[k].planes.begin(), views[k].planes.end());
    visit.others.erase(plane.id);
  }
  return visits;
}

// Whether two visits share another plane, or an edge joins other planes of theirs.
bool AreTied(const MapIndex& index, const Visit& a, const Visit& b) {
  return std::any_of(a.others.begin(), a.others.end(), [&](PlaneId id) {
    if (b.others.contains(id)) return true;
    const std::vector<PlaneId>& neighbours = index.Neighbours(id);
    return std::any_of(neighbours.begin(), neighbours.end(),
                       [&](PlaneId neighbour) { return b.others.contains(neighbour); });
  });
}

// Among the pairs of visits of a plane that nothing else connects, the one with the most evidence.
std::optional<LoneTie> DescribeTie(const MapIndex& index, const Plane& plane,
                                   const std::vector<Visit>& visits) {
  std::optional<LoneTie> tie;
  for (size_t i = 0; i < visits.size(); ++i) {
    for (size_t j = i + 1; j < visits.size(); ++j) {
      const int inliers = std::min(visits[i].inliers, visits[j].inliers);
      if (tie && inliers <= tie->inliers) continue;
      // A visit that shows nothing else can't contradict another one.
      if (visits[i].others.empty() || visits[j].others.empty()) continue;
      if (AreTied(index, visits[i], visits[j])) continue;
      tie = LoneTie{plane.id, visits[i].best, visits[j].best, inliers};
    }
  }
  return tie;
}

}  // namespace

std::vector<LoneTie> FindLoneTies(const MapIndex& index, const std::vector<KeyframeView>& views) {
  std::vector<LoneTie> ties;
  for (const Plane& plane : index.map().planes) {
    const std::optional<LoneTie> tie = DescribeTie(index, plane, FindVisits(index, plane, views));
    if (tie) ties.push_back(*tie);
  }
  return ties;
}

}  // namespace waystone
