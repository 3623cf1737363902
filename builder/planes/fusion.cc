// SPDX-License-Identifier: Apache-2.0
#include "builder/planes/fusion.h"

#include <tbb/parallel_for.h>

#include <Eigen/Dense>
#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "builder/planes/one_surface.h"
#include "builder/planes/outline.h"
#include "builder/planes/plane_features.h"
#include "core/homography/estimate_homography.h"
#include "schema/layers/layer_blobs.h"
#include "schema/layers/planes/surfaces.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

// The share of the features of `plane` (mapped by to_from) inside the convex hull of the other
// plane's that are in `matched`.
double OverlapShare(const Plane& plane, const Matrix3d& to_from, const Plane& other,
                    const std::set<int>& matched) {
  const std::vector<int> inside = FeaturesInsideHull(plane, to_from, PositionsOf(other));
  const auto found = std::ranges::count_if(inside, [&](int f) { return matched.contains(f); });
  return inside.empty() ? 0 : static_cast<double>(found) / static_cast<double>(inside.size());
}

bool OverlapAgrees(const Plane& m, const Plane& n, const FusionMatch& match, double min_overlap) {
  std::set<int> of_m;
  std::set<int> of_n;
  for (const Match& inlier : match.inliers) {
    of_m.insert(inlier.a);
    of_n.insert(inlier.b);
  }
  // The plane that was seen more often has more features than one view can show again: the larger
  // share counts.
  const Matrix3d& m_from_n = match.m_from_n.b_from_a;
  return std::max(OverlapShare(n, m_from_n, m, of_n),
                  OverlapShare(m, m_from_n.inverse(), n, of_m)) >= min_overlap;
}

// Whether a feature of n lies in or near m's reference image, at a position that the matches
// determine. Others could only be expressed by extrapolation.
bool CanBeMoved(const PlaneFeature& feature, const FusionMatch& match, const Keyframe& reference,
                const PlaneLayerOptions& options) {
  const Vector2d x_n = PositionOf(feature.reference);
  return IsInFront(match.m_from_n.b_from_a, x_n) &&
         IsWithinReach(Apply(match.m_from_n.b_from_a, x_n), reference.width, reference.height,
                       options.max_extrapolation) &&
         TransferSigma(match.m_from_n, x_n) <= options.fusion.max_moved_px;
}

// The same surface in two reference images that show different parts of it: both planes stay, and
// an edge with the identity as homology joins them.
Edge SameSurface(const Plane& m, const Plane& n) {
  return {m.id,
          n.id,
          std::min(m.reference, n.reference),
          std::max(m.reference, n.reference),
          Matrix3d::Identity(),
          1.0};
}

// Moves n's features and views into m's reference image, except for features beyond its reach.
void MergeInto(Plane& m, const Plane& n, const FusionMatch& match, const Keyframe& reference,
               const PlaneLayerOptions& options) {
  const Matrix3d& m_from_n = match.m_from_n.b_from_a;
  std::set<int> same;
  for (const Match& inlier : match.inliers) {
    PlaneFeature& feature = m.features[inlier.a];
    feature.votes = std::min(feature.votes + n.features[inlier.b].votes, kMaxVotes);
    feature.visible = std::min(feature.visible + n.features[inlier.b].visible, kMaxVotes);
    same.insert(inlier.b);
  }
  for (int f = 0; f < static_cast<int>(n.features.size()); ++f) {
    if (same.contains(f) || !CanBeMoved(n.features[f], match, reference, options)) continue;
    PlaneFeature feature = n.features[f];
    feature.reference = Transferred(m_from_n, feature.reference);
    m.features.push_back(feature);
    m.descriptors.Append(n.descriptors.row(f));
  }
  for (const PlaneView& view : n.views) {
    const bool known = std::any_of(m.views.begin(), m.views.end(),
                                   [&](const PlaneView& v) { return v.keyframe == view.keyframe; });
    if (known) continue;
    m.views.push_back(
        {view.keyframe, Normalised(m_from_n * view.reference_from_keyframe), view.inliers});
  }
  std::sort(m.views.begin(), m.views.end(),
            [](const PlaneView& a, const PlaneView& b) { return a.keyframe < b.keyframe; });
}

// The edges between planes, while planes are merged.
class PlaneGraph {
 public:
  explicit PlaneGraph(const std::vector<Edge>& edges) {
    for (const Edge& edge : edges) Add(edge);
  }

  // A(m,n) = 1.
  bool AreCovisible(PlaneId m, PlaneId n) const { return edges_.contains(Ordered(m, n)); }

  // Of two edges between the same planes, the first one stays, unless only the other one marks them
  // as one surface.
  void Add(const Edge& edge) {
    const auto [known, is_new] = edges_.try_emplace(Ordered(edge.a, edge.b), edge);
    if (!is_new && !JoinsOneSurface(known->second) && JoinsOneSurface(edge)) known->second = edge;
    neighbours_[edge.a].insert(edge.b);
    neighbours_[edge.b].insert(edge.a);
  }

  // Eq. (6): A' = I_n (A or P_mn A or A P_mn) I_n^T: n's edges pass to m, n's row and column go.
  void Merge(PlaneId m, PlaneId n) {
    for (const PlaneId other : std::exchange(neighbours_[n], {})) {
      Edge edge = edges_.extract(Ordered(n, other)).mapped();
      neighbours_[other].erase(n);
      const bool turned = (edge.a == n) != (m < other);
      if (turned) {  // H^{ba} is the inverse of H^{ab}, the third eigenvalue its reciprocal
        edge.homology = edge.homology.inverse().eval();
        edge.third_eigenvalue = 1 / edge.third_eigenvalue;
      }
      std::tie(edge.a, edge.b) = Ordered(m, other);
      Add(edge);
    }
    neighbours_.erase(n);
  }

  // By (a, b).
  std::vector<Edge> edges() const {
    std::vector<Edge> all;
    for (const auto& [pair, edge] : edges_) all.push_back(edge);
    return all;
  }

 private:
  std::map<PlanePair, Edge> edges_;
  std::map<PlaneId, std::set<PlaneId>> neighbours_;
};

// A set of planes that shrinks as pairs are merged.
class Fuser {
 public:
  Fuser(std::vector<Plane> planes, const std::vector<Edge>& edges,
        const std::vector<Keyframe>& keyframes, FeatureType type, const PlaneLayerOptions& options)
      : keyframes_(keyframes), graph_(edges), type_(type), options_(options) {
    for (Plane& plane : planes) {
      PackedRows packed(type_, plane.descriptors);
      const PlaneId id = plane.id;
      planes_[id] = {std::move(plane), std::move(packed), false};
    }
  }

  void Run(const std::vector<FusionCandidate>& candidates) {
    // Matches all pairs at once in their present state: few planes will have changed by their turn.
    std::vector<std::optional<FusionMatch>> matches(candidates.size());
    tbb::parallel_for(size_t{0}, candidates.size(),
                      [&](size_t i) { matches[i] = MatchNow(candidates[i].m, candidates[i].n); });
    for (size_t i = 0; i < candidates.size(); ++i) Try(candidates[i], matches[i]);
  }

  FusionResult Finish() {
    FusionResult result;
    result.fused = static_cast<int>(merged_into_.size());
    for (const auto& [id, into] : merged_into_) result.merged_into.emplace(id, Root(into));
    result.joined = joined_;
    for (auto& [id, entry] : planes_) result.planes.push_back(std::move(entry.plane));
    result.edges = graph_.edges();
    JoinSurfaces(result.planes, keyframes_, options_.fusion.max_apart_px, result.edges);
    return result;
  }

 private:
  struct Entry {
    Plane plane;
    PackedRows packed;     // its descriptors
    bool changed = false;  // since the beginning
  };

  std::optional<FusionMatch> MatchNow(PlaneId m, PlaneId n) const {
    const Entry& entry_m = planes_.at(m);
    const Plane& plane_n = planes_.at(n).plane;
    std::optional<FusionMatch> match =
        MatchPlanes(entry_m.plane, entry_m.packed, plane_n, options_);
    if (match && !OverlapAgrees(entry_m.plane, plane_n, *match, options_.fusion.min_overlap)) {
      return std::nullopt;
    }
    return match;
  }

  // Line 17: tries a pair, or the planes into which its planes were merged. `first` is the match of
  // the original planes.
  void Try(const FusionCandidate& candidate, const std::optional<FusionMatch>& first) {
    const auto [m, n] = Ordered(Root(candidate.m), Root(candidate.n));
    if (m == n || graph_.AreCovisible(m, n)) return;
    Entry& entry_m = planes_.at(m);
    const Plane& plane_n = planes_.at(n).plane;
    const bool as_before =
        m == candidate.m && n == candidate.n && !entry_m.changed && !planes_.at(n).changed;
    const std::optional<FusionMatch> match = as_before ? first : MatchNow(m, n);
    if (!match) return;
    const Keyframe& reference =
        *std::ranges::lower_bound(keyframes_, entry_m.plane.reference, {}, &Keyframe::id);
    const auto within = std::ranges::count_if(plane_n.features, [&](const PlaneFeature& feature) {
      return CanBeMoved(feature, *match, reference, options_);
    });
    const auto all = static_cast<double>(plane_n.features.size());
    if (static_cast<double>(within) < options_.fusion.min_within_reach * all) {
      graph_.Add(SameSurface(entry_m.plane, plane_n));
      ++joined_;
    } else {
      MergeInto(entry_m.plane, plane_n, *match, reference, options_);
      entry_m.packed = PackedRows(type_, entry_m.plane.descriptors);
      entry_m.changed = true;
      planes_.erase(n);
      merged_into_[n] = m;
      graph_.Merge(m, n);
    }
  }

  PlaneId Root(PlaneId id) const {
    while (merged_into_.contains(id)) id = merged_into_.at(id);
    return id;
  }

  const std::vector<Keyframe>& keyframes_;
  std::map<PlaneId, Entry> planes_;
  std::map<PlaneId, PlaneId> merged_into_;
  PlaneGraph graph_;
  int joined_ = 0;
  FeatureType type_;
  const PlaneLayerOptions& options_;
};

}  // namespace

void FusionOptions::Check() const {
  CheckFields("fusion", *this);
  index.Check();
}

std::optional<FusionMatch> MatchPlanes(const Plane& m, const PackedRows& packed_m, const Plane& n,
                                       const PlaneLayerOptions& options) {
  const std::vector<Match> matches =
      MatchDescriptors(packed_m, m.descriptors.rows(), n.descriptors, options.match);
  const FusionOptions& fusion = options.fusion;
  if (static_cast<int>(matches.size()) < fusion.min_inliers) return std::nullopt;
  MatchedPoints points;  // from n to m
  for (const Match& match : matches) {
    points.from.push_back(PositionOf(n.features[match.b].reference));
    points.to.push_back(PositionOf(m.features[match.a].reference));
  }
  const auto estimate = EstimateHomography(points, options.segmentation.ransac,
                                           options.seed ^ (m.id.value << 20) ^ n.id.value);
  if (!estimate || static_cast<int>(estimate->inliers.size()) < fusion.min_inliers ||
      estimate->inliers.size() < fusion.min_support * static_cast<double>(matches.size())) {
    return std::nullopt;
  }
  FusionMatch result;
  for (const int row : estimate->inliers) result.inliers.push_back(matches[row]);
  result.m_from_n = estimate->to_from;
  return result;
}

FusionResult FusePairs(std::vector<Plane> planes, const std::vector<Edge>& edges,
                       const std::vector<Keyframe>& keyframes,
                       const std::vector<FusionCandidate>& pairs, FeatureType type,
                       const PlaneLayerOptions& options) {
  Fuser fuser(std::move(planes), edges, keyframes, type, options);
  fuser.Run(pairs);
  return fuser.Finish();
}

FusionResult FusePlanes(std::vector<Plane> planes, const std::vector<Edge>& edges,
                        const std::vector<Keyframe>& keyframes, FeatureType type,
                        const PlaneLayerOptions& options) {
  const auto candidates = ProposeFusions(planes, edges, type, options.fusion);
  return FusePairs(std::move(planes), edges, keyframes, candidates, type, options);
}

}  // namespace waystone
