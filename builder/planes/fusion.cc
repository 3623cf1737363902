// SPDX-License-Identifier: Apache-2.0
#include "builder/planes/fusion.h"

#include <tbb/parallel_for.h>

#include <Eigen/Dense>
#include <algorithm>
#include <map>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <set>

#include "builder/planes/plane_features.h"
#include "core/base/error.h"

namespace waystone {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using PlanePair = std::pair<PlaneId, PlaneId>;

PlanePair Ordered(PlaneId a, PlaneId b) { return a < b ? PlanePair{a, b} : PlanePair{b, a}; }

Vector2d PositionOf(const PlaneFeature& feature) {
  return {feature.reference.x_px, feature.reference.y_px};
}

// The features that may vote: those seen most often, at most `count`, ascending.
std::vector<int> Voters(const Plane& plane, int count) {
  std::vector<int> order(plane.features.size());
  std::iota(order.begin(), order.end(), 0);
  if (static_cast<int>(order.size()) <= count) return order;
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return plane.features[a].votes > plane.features[b].votes; });
  order.resize(count);
  std::sort(order.begin(), order.end());
  return order;
}

// All voters' descriptors in one block, and whose each is.
struct Ballot {
  Descriptors descriptors;
  std::vector<int> plane;  // index of the plane of each row
};

Ballot CollectVoters(const std::vector<Plane>& planes, FeatureType type, int max_voters) {
  Ballot ballot{Descriptors(DescriptorBytes(type)), {}};
  for (int p = 0; p < static_cast<int>(planes.size()); ++p) {
    for (int f : Voters(planes[p], max_voters)) {
      ballot.descriptors.Append(planes[p].descriptors.row(f));
      ballot.plane.push_back(p);
    }
  }
  return ballot;
}

// Votes of one plane's voters for the others.
std::map<int, int> VotesOf(const Ballot& ballot, int first, int last, FeatureType type,
                           const FusionOptions& options) {
  const int own = ballot.plane[first];
  Descriptors queries(ballot.descriptors.bytes());
  for (int row = first; row < last; ++row) queries.Append(ballot.descriptors.row(row));
  // The nearest is the feature itself.
  const int k = options.votes_per_feature + 1;
  const std::vector<Neighbour> nearest = NearestNeighbours(queries, ballot.descriptors, type, k);
  std::map<int, int> votes;
  for (int q = 0; q < queries.rows(); ++q) {
    std::set<int> voted;
    for (int i = 0; i < k; ++i) {
      const int row = nearest[static_cast<size_t>(q) * k + i].row;
      if (row < 0 || ballot.plane[row] == own) continue;
      if (voted.insert(ballot.plane[row]).second) ++votes[ballot.plane[row]];
    }
  }
  return votes;
}

// Where each plane's rows begin in the ballot; one more for the end.
std::vector<int> Starts(const Ballot& ballot, int planes) {
  std::vector<int> starts(planes + 1, static_cast<int>(ballot.plane.size()));
  for (int row = static_cast<int>(ballot.plane.size()) - 1; row >= 0; --row) {
    starts[ballot.plane[row]] = row;
  }
  for (int p = planes - 1; p >= 0; --p) starts[p] = std::min(starts[p], starts[p + 1]);
  return starts;
}

std::set<PlanePair> Covisible(const std::vector<Edge>& edges) {
  std::set<PlanePair> pairs;
  for (const Edge& edge : edges) pairs.insert(Ordered(edge.a, edge.b));
  return pairs;
}

// Features of `plane` (mapped by to_from) inside the outline of another one, and how many of them
// are in `matched`.
double OverlapShare(const Plane& plane, const Matrix3d& to_from, const Plane& other,
                    const std::set<int>& matched) {
  std::vector<cv::Point2f> outline;
  for (const Vector2d& p : OutlineOf(other.features)) {
    outline.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  }
  int inside = 0;
  int found = 0;
  for (int f = 0; f < static_cast<int>(plane.features.size()); ++f) {
    const Vector2d x = Apply(to_from, PositionOf(plane.features[f]));
    if (!x.allFinite()) continue;
    const cv::Point2f point(static_cast<float>(x.x()), static_cast<float>(x.y()));
    if (cv::pointPolygonTest(outline, point, false) < 0) continue;
    ++inside;
    found += matched.contains(f);
  }
  return inside == 0 ? 0 : static_cast<double>(found) / inside;
}

bool OverlapAgrees(const Plane& m, const Plane& n, const FusionMatch& match, double min_overlap) {
  std::set<int> of_m;
  std::set<int> of_n;
  for (const Match& inlier : match.inliers) {
    of_m.insert(inlier.a);
    of_n.insert(inlier.b);
  }
  // The plane that was seen more often has more features than one look can find again: the better
  // of the two shares counts.
  return std::max(OverlapShare(n, match.m_from_n, m, of_n),
                  OverlapShare(m, match.m_from_n.inverse(), n, of_m)) >= min_overlap;
}

// Share of n's features that lie in or near m's reference image. The others could only be expressed
// by extrapolation.
double ShareWithinReach(const Plane& n, const FusionMatch& match, const Keyframe& reference,
                        double max_extrapolation) {
  int within = 0;
  for (const PlaneFeature& feature : n.features) {
    within += IsWithinReach(Apply(match.m_from_n, PositionOf(feature)), reference.width,
                            reference.height, max_extrapolation);
  }
  return static_cast<double>(within) / static_cast<double>(n.features.size());
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

// Moves n's features and views into m's reference image.
void MergeInto(Plane& m, const Plane& n, const FusionMatch& match) {
  std::set<int> same;
  for (const Match& inlier : match.inliers) {
    m.features[inlier.a].votes += n.features[inlier.b].votes;
    m.features[inlier.a].visible += n.features[inlier.b].visible;
    same.insert(inlier.b);
  }
  for (int f = 0; f < static_cast<int>(n.features.size()); ++f) {
    if (same.contains(f)) continue;
    PlaneFeature feature = n.features[f];
    feature.reference = Transferred(match.m_from_n, feature.reference);
    if (!PositionOf(feature).allFinite()) continue;
    m.features.push_back(feature);
    m.descriptors.Append(n.descriptors.row(f));
  }
  for (const PlaneView& view : n.views) {
    const bool known = std::any_of(m.views.begin(), m.views.end(),
                                   [&](const PlaneView& v) { return v.keyframe == view.keyframe; });
    if (known) continue;
    m.views.push_back(
        {view.keyframe, Normalised(match.m_from_n * view.reference_from_keyframe), view.inliers});
  }
  std::sort(m.views.begin(), m.views.end(),
            [](const PlaneView& a, const PlaneView& b) { return a.keyframe < b.keyframe; });
}

// Eq. (6): A' = I_n (A or P_mn A or A P_mn) I_n^T: n's edges pass to m, n's row and column go.
void PassEdges(PlaneId m, PlaneId n, std::vector<Edge>& edges) {
  for (Edge& edge : edges) {
    if (edge.a != n && edge.b != n) continue;
    const PlaneId other = edge.a == n ? edge.b : edge.a;
    const bool turned = (edge.a == n) != (m < other);
    if (turned) {  // H^{ba} is the inverse of H^{ab}, the third eigenvalue its reciprocal
      edge.homology = edge.homology.inverse().eval();
      edge.third_eigenvalue = 1 / edge.third_eigenvalue;
    }
    edge.a = std::min(m, other);
    edge.b = std::max(m, other);
  }
  std::stable_sort(edges.begin(), edges.end(), [](const Edge& x, const Edge& y) {
    return std::pair(x.a, x.b) < std::pair(y.a, y.b);
  });
  const auto repeated = std::unique(edges.begin(), edges.end(), [](const Edge& x, const Edge& y) {
    return x.a == y.a && x.b == y.b;
  });
  edges.erase(repeated, edges.end());
}

std::vector<FusionCandidate> EveryPair(const std::vector<Plane>& planes,
                                       const std::vector<Edge>& edges) {
  const std::set<PlanePair> covisible = Covisible(edges);
  std::vector<FusionCandidate> candidates;
  for (size_t m = 0; m < planes.size(); ++m) {
    for (size_t n = m + 1; n < planes.size(); ++n) {
      if (!covisible.contains({planes[m].id, planes[n].id})) {
        candidates.push_back({planes[m].id, planes[n].id, 0});
      }
    }
  }
  return candidates;
}

}  // namespace

void FusionOptions::Check() const {
  const bool good = min_votes >= 1 && votes_per_feature >= 1 && max_voters >= 1 &&
                    min_inliers >= 5 && min_support >= 0 && min_support <= 1 && min_overlap >= 0 &&
                    min_overlap <= 1 && min_within_reach >= 0 && min_within_reach <= 1;
  if (!good) {
    throw MapError(ErrorCode::kBadOptions,
                   "fusion: an option is out of its range; leave them at their defaults");
  }
}

std::vector<FusionCandidate> ProposeFusions(const std::vector<Plane>& planes,
                                            const std::vector<Edge>& edges, FeatureType type,
                                            const FusionOptions& options) {
  options.Check();
  const int count = static_cast<int>(planes.size());
  const Ballot ballot = CollectVoters(planes, type, options.max_voters);
  const std::vector<int> starts = Starts(ballot, count);
  std::vector<std::map<int, int>> votes(count);
  tbb::parallel_for(0, count, [&](int p) {
    if (starts[p] < starts[p + 1]) {
      votes[p] = VotesOf(ballot, starts[p], starts[p + 1], type, options);
    }
  });
  std::map<PlanePair, int> sums;
  for (int p = 0; p < count; ++p) {
    for (const auto& [q, n] : votes[p]) sums[Ordered(planes[p].id, planes[q].id)] += n;
  }
  const std::set<PlanePair> covisible = Covisible(edges);
  std::vector<FusionCandidate> candidates;
  for (const auto& [pair, n] : sums) {
    if (n >= options.min_votes && !covisible.contains(pair)) {
      candidates.push_back({pair.first, pair.second, n});
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& a, const auto& b) { return a.votes > b.votes; });
  return candidates;
}

std::optional<FusionMatch> MatchPlanes(const Plane& m, const Plane& n, FeatureType type,
                                       const PlaneLayerOptions& options) {
  const std::vector<Match> matches =
      MatchDescriptors(m.descriptors, n.descriptors, type, options.match);
  const FusionOptions& fusion = options.fusion;
  if (static_cast<int>(matches.size()) < fusion.min_inliers) return std::nullopt;
  MatchedPoints points;  // from n to m
  for (const Match& match : matches) {
    points.from.push_back(PositionOf(n.features[match.b]));
    points.to.push_back(PositionOf(m.features[match.a]));
  }
  const LocalRansacOptions& ransac = options.segmentation.ransac;
  const Neighbourhoods neighbourhoods(points.from, 2 * ransac.neighbourhood);
  std::vector<int> all(points.size());
  std::iota(all.begin(), all.end(), 0);
  Random random(options.seed ^ (m.id.value << 20) ^ n.id.value);
  const auto fit = FindPlane(points, all, neighbourhoods, ransac, random);
  if (!fit || static_cast<int>(fit->inliers.size()) < fusion.min_inliers ||
      fit->inliers.size() < fusion.min_support * static_cast<double>(matches.size())) {
    return std::nullopt;
  }
  PointPairs pairs;
  FusionMatch result;
  for (int row : fit->inliers) {
    pairs.Add(points.from[row], points.to[row]);
    result.inliers.push_back(matches[row]);
  }
  const auto refined = RefineHomography(pairs, fit->model.to_from);
  if (!refined) return std::nullopt;
  result.m_from_n = refined->b_from_a;
  if (!OverlapAgrees(m, n, result, fusion.min_overlap)) return std::nullopt;
  return result;
}

// A set of planes that shrinks as pairs are merged.
class Fuser {
 public:
  Fuser(std::vector<Plane> planes, std::vector<Edge> edges, const std::vector<Keyframe>& keyframes,
        FeatureType type, const PlaneLayerOptions& options)
      : edges_(std::move(edges)), type_(type), options_(options) {
    for (const Keyframe& keyframe : keyframes) keyframes_[keyframe.id] = &keyframe;
    for (Plane& plane : planes) planes_[plane.id] = std::move(plane);
    covisible_ = Covisible(edges_);
  }

  // Line 17: tries a pair, or what its planes have become.
  void Try(const FusionCandidate& candidate) {
    const auto [m, n] = Ordered(Root(candidate.m), Root(candidate.n));
    if (m == n || covisible_.contains({m, n})) return;
    Plane& plane_m = planes_.at(m);
    Plane& plane_n = planes_.at(n);
    const auto match = MatchPlanes(plane_m, plane_n, type_, options_);
    if (!match) return;
    const double share = ShareWithinReach(plane_n, *match, *keyframes_.at(plane_m.reference),
                                          options_.max_extrapolation);
    if (share < options_.fusion.min_within_reach) {
      edges_.push_back(SameSurface(plane_m, plane_n));
    } else {
      MergeInto(plane_m, plane_n, *match);
      planes_.erase(n);
      merged_into_[n] = m;
      PassEdges(m, n, edges_);
    }
    covisible_ = Covisible(edges_);
  }

  FusionResult Finish() {
    FusionResult result;
    result.fused = static_cast<int>(merged_into_.size());
    for (auto& [id, plane] : planes_) result.planes.push_back(std::move(plane));
    std::sort(edges_.begin(), edges_.end(), [](const Edge& x, const Edge& y) {
      return std::pair(x.a, x.b) < std::pair(y.a, y.b);
    });
    result.edges = std::move(edges_);
    return result;
  }

 private:
  PlaneId Root(PlaneId id) const {
    while (merged_into_.contains(id)) id = merged_into_.at(id);
    return id;
  }

  std::map<KeyframeId, const Keyframe*> keyframes_;
  std::map<PlaneId, Plane> planes_;
  std::map<PlaneId, PlaneId> merged_into_;
  std::vector<Edge> edges_;
  std::set<PlanePair> covisible_;
  FeatureType type_;
  const PlaneLayerOptions& options_;
};

FusionResult FusePlanes(std::vector<Plane> planes, std::vector<Edge> edges,
                        const std::vector<Keyframe>& keyframes, FeatureType type,
                        const PlaneLayerOptions& options, bool exhaustive) {
  const std::vector<FusionCandidate> candidates =
      exhaustive ? EveryPair(planes, edges) : ProposeFusions(planes, edges, type, options.fusion);
  Fuser fuser(std::move(planes), std::move(edges), keyframes, type, options);
  for (const FusionCandidate& candidate : candidates) fuser.Try(candidate);
  return fuser.Finish();
}

}  // namespace waystone
