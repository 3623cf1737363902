// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/prune_map.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <set>
#include <utility>

#include "builder/joining/joinable.h"
#include "builder/joining/kept_looks.h"
#include "builder/joining/kept_poses.h"
#include "builder/planes/outline.h"
#include "builder/planes/plane_features.h"
#include "core/base/error.h"
#include "schema/sessions.h"

namespace waystone {
namespace {

using Eigen::Vector2d;

// The number of features around one that are considered with it, and the largest share of all their
// looks that may have found them.
constexpr size_t kAskedAround = 4;
constexpr double kMostFoundAround = 0.25;

// What one sequence found of the features of a plane or a keyframe.
struct LookRow {
  SequenceId sequence;
  const std::vector<FeatureLooks>* looks;
};

// Of several rows together.
struct LookSum {
  int looked = 0;
  int found = 0;

  void Add(const LookSum& other) {
    looked += other.looked;
    found += other.found;
  }
};

// The features of a plane or a keyframe, with what later walks found of them.
class LookedFor {
 public:
  LookedFor(std::vector<Vector2d> positions, std::vector<LookRow> rows)
      : positions_(std::move(positions)), rows_(std::move(rows)) {
    sums_.assign(rows_.size() + 1, std::vector<LookSum>(positions_.size()));
    for (size_t r = rows_.size(); r-- > 0;) {
      for (size_t f = 0; f < positions_.size(); ++f) {
        const FeatureLooks& one = (*rows_[r].looks)[f];
        sums_[r][f] = sums_[r + 1][f];
        sums_[r][f].Add({one.looked, one.found});
      }
    }
  }

  // For each feature to remove: the sequences that missed it.
  std::map<int, std::set<SequenceId>> FindGone(int min_looks) const {
    std::map<int, std::set<SequenceId>> gone;
    for (size_t f = 0; f < positions_.size(); ++f) {
      const size_t since = SinceFound(f);
      if (Sum(f, since).looked < min_looks || WasFoundAround(f, since)) continue;
      std::set<SequenceId>& missed = gone[static_cast<int>(f)];
      for (size_t r = since; r < rows_.size(); ++r) {
        if ((*rows_[r].looks)[f].looked > 0) missed.insert(rows_[r].sequence);
      }
    }
    return gone;
  }

  int CountLookedFor() const {
    int count = 0;
    for (size_t f = 0; f < positions_.size(); ++f) count += Sum(f, 0).looked > 0;
    return count;
  }

 private:
  // The first row after the last that found the feature.
  size_t SinceFound(size_t f) const {
    size_t since = rows_.size();
    while (since > 0 && (*rows_[since - 1].looks)[f].found == 0) --since;
    return since;
  }

  const LookSum& Sum(size_t f, size_t since) const { return sums_[since][f]; }

  // Whether walks found the nearest features in the same rows; true if none was looked for.
  bool WasFoundAround(size_t f, size_t since) const {
    std::vector<std::pair<double, size_t>> around;
    for (size_t other = 0; other < positions_.size(); ++other) {
      if (other == f || Sum(other, since).looked == 0) continue;
      around.emplace_back((positions_[other] - positions_[f]).squaredNorm(), other);
    }
    if (around.empty()) return true;
    const size_t asked = std::min(kAskedAround, around.size());
    std::ranges::partial_sort(around, around.begin() + static_cast<std::ptrdiff_t>(asked));
    LookSum all = Sum(f, since);
    for (size_t i = 0; i < asked; ++i) {
      all.Add(Sum(around[i].second, since));
    }
    return all.found > kMostFoundAround * all.looked;
  }

  std::vector<Vector2d> positions_;
  std::vector<LookRow> rows_;               // by sequence, in the order in which they were added
  std::vector<std::vector<LookSum>> sums_;  // of each row and those after it, by feature
};

// The indices 0 to count - 1 that aren't removed.
std::vector<int> Staying(size_t count, const std::map<int, std::set<SequenceId>>& gone) {
  std::vector<int> kept;
  for (int f = 0; f < static_cast<int>(count); ++f) {
    if (!gone.contains(f)) kept.push_back(f);
  }
  return kept;
}

template <class Value>
std::vector<Value> Chosen(const std::vector<Value>& values, const std::vector<int>& kept) {
  std::vector<Value> chosen;
  for (const int i : kept) chosen.push_back(values[static_cast<size_t>(i)]);
  return chosen;
}

class Pruner {
 public:
  Pruner(int min_looks, int min_features, MapData& map, PruneReport& report)
      : min_looks_(min_looks), min_features_(min_features), map_(map), report_(report) {
    const std::vector<MapSession> sessions = SessionsOf(map);
    for (size_t s = 0; s < sessions.size(); ++s) {
      report.sessions.push_back({sessions[s].name, 0, 0});
      for (const SequenceId id : sessions[s].sequences) session_of_[id] = s;
    }
  }

  void Run() {
    for (Plane& plane : map_.planes) PrunePlane(plane);
    for (Keyframe& keyframe : map_.keyframes) PruneLandmarks(keyframe);
    RemoveEndedPlanes();
    std::erase_if(report_.sessions, [](const MissingSession& session) {
      return session.plane_features == 0 && session.landmarks == 0;
    });
  }

 private:
  void PrunePlane(Plane& plane) {
    std::vector<LookRow> rows;
    const std::vector<PlaneLooks>& looks = map_.looks.planes;
    auto row = std::ranges::lower_bound(looks, plane.id, {}, &PlaneLooks::plane);
    for (; row != looks.end() && row->plane == plane.id; ++row) {
      rows.push_back({row->sequence, &row->features});
    }
    if (rows.empty()) return;
    std::vector<Vector2d> positions;
    for (const PlaneFeature& feature : plane.features) {
      positions.push_back(PositionOf(feature.reference));
    }
    const LookedFor features(std::move(positions), std::move(rows));
    const auto gone = features.FindGone(min_looks_);
    report_.looked_for += features.CountLookedFor();
    if (gone.empty()) return;
    Count(gone, &MissingSession::plane_features);
    KeepFeatures(Staying(plane.features.size(), gone), plane);
    const int left = static_cast<int>(plane.features.size());
    const bool ends = left < min_features_;
    report_.plane_features += static_cast<int>(gone.size()) + (ends ? left : 0);
    report_.planes.push_back(
        {plane.id, plane.reference, static_cast<int>(gone.size()), ends ? 0 : left});
    if (ends) ended_.insert(plane.id);
  }

  void PruneLandmarks(Keyframe& keyframe) {
    std::vector<LookRow> rows;
    const std::vector<LandmarkLooks>& looks = map_.looks.landmarks;
    auto row = std::ranges::lower_bound(looks, keyframe.id, {}, &LandmarkLooks::keyframe);
    for (; row != looks.end() && row->keyframe == keyframe.id; ++row) {
      rows.push_back({row->sequence, &row->landmarks});
    }
    if (rows.empty()) return;
    Landmarks& landmarks = keyframe.landmarks;
    std::vector<Vector2d> positions;
    for (const ImagePosition& position : landmarks.positions) {
      positions.push_back(DecodePosition(position, keyframe.width, keyframe.height));
    }
    const LookedFor features(std::move(positions), std::move(rows));
    const auto gone = features.FindGone(min_looks_);
    report_.looked_for += features.CountLookedFor();
    if (gone.empty()) return;
    Count(gone, &MissingSession::landmarks);
    report_.landmarks += static_cast<int>(gone.size());
    const std::vector<int> kept = Staying(landmarks.positions.size(), gone);
    KeepDepths(keyframe.id, kept);
    landmarks.positions = Chosen(landmarks.positions, kept);
    Descriptors codes;  // without bytes where no landmark is left, as where there never was one
    if (!kept.empty()) codes = Descriptors(landmarks.codes.bytes());
    for (const int i : kept) codes.Append(landmarks.codes.row(i));
    landmarks.codes = std::move(codes);
  }

  void KeepDepths(KeyframeId id, const std::vector<int>& kept) {
    if (!map_.poses) return;
    std::vector<LandmarkDepths>& all = map_.poses->landmark_depths;
    const auto depths = std::ranges::lower_bound(all, id, {}, &LandmarkDepths::keyframe);
    if (depths == all.end() || depths->keyframe != id) return;
    depths->landmarks = Chosen(depths->landmarks, kept);
  }

  void Count(const std::map<int, std::set<SequenceId>>& gone, int MissingSession::*count) {
    for (const auto& [feature, sequences] : gone) {
      std::set<size_t> sessions;
      for (const SequenceId id : sequences) sessions.insert(session_of_.at(id));
      for (const size_t s : sessions) ++(report_.sessions[s].*count);
    }
  }

  void RemoveEndedPlanes() {
    std::erase_if(map_.planes, [&](const Plane& plane) { return ended_.contains(plane.id); });
    const size_t edges = std::erase_if(map_.edges, [&](const Edge& edge) {
      return ended_.contains(edge.a) || ended_.contains(edge.b);
    });
    report_.edges = static_cast<int>(edges);
  }

  int min_looks_;
  int min_features_;
  MapData& map_;
  PruneReport& report_;
  std::map<SequenceId, size_t> session_of_;  // in report_.sessions
  std::set<PlaneId> ended_;
};

}  // namespace

PruneResult PruneMap(MapData map, int min_looks, const BuildOptions& options) {
  options.Check();
  if (min_looks < 1) {
    throw MapError(ErrorCode::kBadOptions,
                   "min_looks is " + std::to_string(min_looks) + "; it must be 1 or more");
  }
  if (map.looks.empty()) {
    throw MapError(ErrorCode::kBadRequest,
                   Named(map) + " was never looked at again; add a walk first (waystone add)");
  }
  PruneResult result;
  const NamedBefore named(map);
  const LooksBefore looks(map);
  const PosesBefore poses(map);
  Pruner(min_looks, options.planes.min_features, map, result.report).Run();
  if (result.report.changed()) {
    OutlinePlanes(map);
    looks.KeepLooks(map);
    poses.KeepPoses(map);
    result.report.names = named.KeepNames(map);
    CompleteJoined(options, {.planes = true, .appearance = false}, map);
  }
  result.map = std::move(map);
  return result;
}

}  // namespace waystone
