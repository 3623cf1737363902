// SPDX-License-Identifier: Apache-2.0
#include "localizer/planes/shortlist.h"

#include <algorithm>
#include <functional>

namespace waystone {
namespace {

// Counts votes, at most one a voter for each candidate.
class Ballot {
 public:
  explicit Ballot(size_t candidates) : votes_(candidates, 0), last_voter_(candidates, -1) {}

  void Vote(int voter, int candidate) {
    if (last_voter_[candidate] == voter) return;
    last_voter_[candidate] = voter;
    ++votes_[candidate];
  }
  int votes(int candidate) const { return votes_[candidate]; }

 private:
  std::vector<int> votes_;
  std::vector<int> last_voter_;
};

template <class Candidate, class Rank>
void KeepBest(double min_votes, int max_kept, Rank Candidate::*rank,
              std::vector<Candidate>& candidates) {
  std::erase_if(candidates, [&](const auto& one) { return one.votes < min_votes; });
  std::ranges::stable_sort(candidates, std::ranges::greater{}, rank);
  if (std::ssize(candidates) > max_kept) candidates.resize(max_kept);
}

// `per_feature` votes are what each feature of the index gets on average.
ShortlistedKeyframe CountVotes(const MapIndex& index, int keyframe, const Ballot& planes,
                               const Ballot& keyframes, double per_feature) {
  double votes = keyframes.votes(keyframe);
  double features = index.map().keyframes[keyframe].landmarks.size();
  for (const MapIndex::SeenPlane& seen : index.PlanesSeenBy(keyframe)) {
    const Plane& plane = index.map().planes[seen.plane];
    if (plane.features.empty()) continue;
    const auto all = static_cast<double>(plane.features.size());
    const double share = std::min(1.0, plane.views[seen.view].inliers / all);
    votes += share * planes.votes(seen.plane);
    features += share * all;
  }
  return {keyframe, votes, votes - per_feature * features};
}

}  // namespace

Shortlist VoteForPlaces(const MapIndex& index, const Features& query,
                        const PlaneQueryOptions& options) {
  const int k = options.votes_per_feature;
  const std::vector<Neighbour> nearest =
      index.search().Nearest(query.descriptors, k, options.probes);
  Ballot planes(index.map().planes.size());
  Ballot keyframes(index.map().keyframes.size());
  int votes = 0;
  for (int q = 0; q < query.size(); ++q) {
    for (int i = 0; i < k; ++i) {
      const int row = nearest[static_cast<size_t>(q) * k + i].row;
      if (row < 0) continue;
      ++votes;
      const int plane = index.PlaneOfRow(row);
      plane >= 0 ? planes.Vote(q, plane) : keyframes.Vote(q, index.KeyframeOfRow(row));
    }
  }
  Shortlist shortlist;
  for (int p = 0; p < static_cast<int>(index.map().planes.size()); ++p) {
    shortlist.planes.push_back({p, planes.votes(p)});
  }
  const double per_feature = votes / std::max(1.0, static_cast<double>(index.search().rows()));
  for (int f = 0; f < static_cast<int>(index.map().keyframes.size()); ++f) {
    shortlist.keyframes.push_back(CountVotes(index, f, planes, keyframes, per_feature));
  }
  KeepBest(options.min_votes, options.max_candidates, &ShortlistedPlane::votes, shortlist.planes);
  KeepBest(options.min_votes, options.max_keyframes, &ShortlistedKeyframe::excess,
           shortlist.keyframes);
  return shortlist;
}

std::vector<ShortlistedPlane> ShortlistPlanes(const MapIndex& index, const Features& query,
                                              const PlaneQueryOptions& options) {
  return VoteForPlaces(index, query, options).planes;
}

}  // namespace waystone
