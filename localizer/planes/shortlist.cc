// SPDX-License-Identifier: Apache-2.0
#include "localizer/planes/shortlist.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>

namespace waystone {
namespace {

// Adds up votes; only a voter's first one for each candidate counts.
class Ballot {
 public:
  explicit Ballot(size_t candidates)
      : votes_(candidates, 0), weights_(candidates, 0), last_voter_(candidates, -1) {}

  // `counts`: whether it counts as a vote in addition to its weight.
  void Vote(int voter, int candidate, bool counts, double weight) {
    if (last_voter_[candidate] == voter) return;
    last_voter_[candidate] = voter;
    votes_[candidate] += counts;
    weights_[candidate] += weight;
  }
  int votes(int candidate) const { return votes_[candidate]; }
  double weight(int candidate) const { return weights_[candidate]; }

 private:
  std::vector<int> votes_;
  std::vector<double> weights_;
  std::vector<int> last_voter_;
};

// How much a neighbour of a query feature supports what it belongs to: more, the nearer it is than
// the last neighbour, which represents what any feature would find (McCann and Lowe, Local Naive
// Bayes Nearest Neighbor, CVPR 2012), and the fewer other features of the query have it among their
// neighbours (bursts: Jegou, Douze and Schmid, CVPR 2009).
double WeightOf(FeatureType type, const Neighbour& neighbour, const Neighbour& last, int voters) {
  if (last.distance <= 0) return 0;
  return (1 - DistanceRatio(type, neighbour.distance, last.distance)) / voters;
}

// Nearest neighbours of each feature of a query, and how many features have each row among theirs.
class QueryNeighbours {
 public:
  QueryNeighbours(const MapIndex& index, const Features& query, int k, int probes)
      : type_(query.type),
        k_(k),
        all_(index.search().Nearest(query.descriptors, k, probes)),
        voters_(index.search().rows(), 0) {
    for (const Neighbour& one : all_) {
      if (one.row >= 0) ++voters_[one.row];
    }
  }

  // Nearest first; fewer than k in a map of few features.
  std::span<const Neighbour> Of(int feature) const {
    const std::span all = std::span(all_).subspan(static_cast<size_t>(feature) * k_, k_);
    return all.first(std::ranges::find(all, -1, &Neighbour::row) - all.begin());
  }
  double Weigh(const Neighbour& neighbour, const Neighbour& last) const {
    return WeightOf(type_, neighbour, last, voters_[neighbour.row]);
  }

 private:
  FeatureType type_;
  int k_;
  std::vector<Neighbour> all_;
  std::vector<int> voters_;
};

struct Ballots {
  Ballot planes;
  Ballot keyframes;
  double weight = 0;  // of all votes
};

Ballots Vote(const MapIndex& index, const Features& query, const PlaneQueryOptions& options) {
  const QueryNeighbours neighbours(
      index, query, std::max(options.votes_per_feature, options.neighbours), options.probes);
  Ballots ballots{Ballot(index.map().planes.size()), Ballot(index.map().keyframes.size())};
  for (int q = 0; q < query.size(); ++q) {
    const std::span<const Neighbour> nearest = neighbours.Of(q);
    for (size_t i = 0; i < nearest.size(); ++i) {
      const int row = nearest[i].row;
      const double weight = neighbours.Weigh(nearest[i], nearest.back());
      const bool counts = static_cast<int>(i) < options.votes_per_feature;
      const int plane = index.PlaneOfRow(row);
      plane >= 0 ? ballots.planes.Vote(q, plane, counts, weight)
                 : ballots.keyframes.Vote(q, index.KeyframeOfRow(row), counts, weight);
      ballots.weight += weight;
    }
  }
  return ballots;
}

// `per_feature` is the weight that each feature of the index gets on average.
ShortlistedKeyframe WeighKeyframe(const MapIndex& index, int keyframe, const Ballots& ballots,
                                  double per_feature) {
  ShortlistedKeyframe weighed{keyframe, 0};
  double weight = ballots.keyframes.weight(keyframe);
  double features = index.map().keyframes[keyframe].landmarks.size();
  for (const MapIndex::SeenPlane& seen : index.PlanesSeenBy(keyframe)) {
    const Plane& plane = index.map().planes[seen.plane];
    if (plane.features.empty()) continue;
    const auto all = static_cast<double>(plane.features.size());
    const double share = std::min(1.0, plane.views[seen.view].inliers / all);
    weight += share * ballots.planes.weight(seen.plane);
    features += share * all;
  }
  const double by_chance = per_feature * features;
  if (by_chance > 0) weighed.excess = (weight - by_chance) / std::sqrt(by_chance);
  return weighed;
}

template <class Candidate, class Rank>
void KeepBest(int max_kept, Rank Candidate::*rank, std::vector<Candidate>& candidates) {
  std::ranges::stable_sort(candidates, std::ranges::greater{}, rank);
  if (std::ssize(candidates) > max_kept) candidates.resize(max_kept);
}

}  // namespace

Shortlist VoteForPlaces(const MapIndex& index, const Features& query,
                        const PlaneQueryOptions& options) {
  const Ballots ballots = Vote(index, query, options);
  Shortlist shortlist;
  for (int p = 0; p < static_cast<int>(index.map().planes.size()); ++p) {
    shortlist.planes.push_back({p, ballots.planes.votes(p)});
  }
  const double per_feature =
      ballots.weight / std::max(1.0, static_cast<double>(index.search().rows()));
  for (int f = 0; f < static_cast<int>(index.map().keyframes.size()); ++f) {
    shortlist.keyframes.push_back(WeighKeyframe(index, f, ballots, per_feature));
  }
  std::erase_if(shortlist.planes, [&](const auto& one) { return one.votes < options.min_votes; });
  KeepBest(options.max_candidates, &ShortlistedPlane::votes, shortlist.planes);
  KeepBest(options.max_keyframes, &ShortlistedKeyframe::excess, shortlist.keyframes);
  return shortlist;
}

std::vector<ShortlistedPlane> ShortlistPlanes(const MapIndex& index, const Features& query,
                                              const PlaneQueryOptions& options) {
  return VoteForPlaces(index, query, options).planes;
}

}  // namespace waystone
