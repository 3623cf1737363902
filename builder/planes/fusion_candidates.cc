// SPDX-License-Identifier: Apache-2.0
#include "builder/planes/fusion_candidates.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <map>
#include <numeric>

#include "builder/planes/plane_features.h"
#include "core/features/keypoint_grid.h"
#include "core/search/search_index.h"

namespace waystone {
namespace {

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

// All voters' descriptors, plane after plane.
struct Ballot {
  Descriptors descriptors;
  std::vector<int> plane;   // index of the plane of each row
  std::vector<int> starts;  // first row of each plane, and one more for the end
};

Ballot CollectVoters(const std::vector<Plane>& planes, FeatureType type, int max_voters) {
  Ballot ballot{Descriptors(DescriptorBytes(type)), {}, {0}};
  for (int p = 0; p < static_cast<int>(planes.size()); ++p) {
    for (int f : Voters(planes[p], max_voters)) {
      ballot.descriptors.Append(planes[p].descriptors.row(f));
      ballot.plane.push_back(p);
    }
    ballot.starts.push_back(static_cast<int>(ballot.plane.size()));
  }
  return ballot;
}

SearchIndex IndexOf(const Ballot& ballot, FeatureType type, const FusionOptions& options) {
  const int rows = ballot.descriptors.rows();
  const InvertedFile file = BuildInvertedFile(ballot.descriptors, type, options.index);
  SearchIndex index = file.list_of_row.empty() ? SearchIndex(type, rows) : SearchIndex(type, file);
  for (int row = 0; row < rows; ++row) index.Set(row, ballot.descriptors.row(row));
  return index;
}

constexpr int kNobody = -1;

// Votes of features for the planes of the ballot, except `own`.
std::map<int, int> CountVotes(const Ballot& ballot, DescriptorsView voters, int own,
                              const SearchIndex& index, FeatureType type,
                              const FusionOptions& options) {
  const int k = options.neighbours;
  const std::vector<Neighbour> nearest = index.Nearest(voters, k, options.probes);
  const double alike = DistanceAt(type, options.max_vote_distance);
  std::map<int, int> votes;
  for (int q = 0; q < voters.rows(); ++q) {
    const Neighbour* of_query = nearest.data() + static_cast<size_t>(q) * k;
    const int by_chance = of_query[k - 1].distance;
    std::vector<int> voted;
    for (int i = 0; i < k && static_cast<int>(voted.size()) < options.votes_per_feature; ++i) {
      const auto& [row, distance] = of_query[i];
      if (row < 0) break;
      if (distance > alike && !PassesRatio(type, distance, by_chance, options.max_vote_ratio))
        break;
      const int plane = ballot.plane[row];
      if (plane == own || std::find(voted.begin(), voted.end(), plane) != voted.end()) continue;
      voted.push_back(plane);
      ++votes[plane];
    }
  }
  return votes;
}

// The voters of one plane.
Descriptors VotersOf(const Ballot& ballot, int plane) {
  Descriptors voters(ballot.descriptors.bytes());
  for (int row = ballot.starts[plane]; row < ballot.starts[plane + 1]; ++row) {
    voters.Append(ballot.descriptors.row(row));
  }
  return voters;
}

}  // namespace

PlanePair Ordered(PlaneId a, PlaneId b) { return a < b ? PlanePair{a, b} : PlanePair{b, a}; }

std::set<PlanePair> Covisible(const std::vector<Edge>& edges) {
  std::set<PlanePair> pairs;
  for (const Edge& edge : edges) pairs.insert(Ordered(edge.a, edge.b));
  return pairs;
}

std::vector<FusionCandidate> ProposeFusions(const std::vector<Plane>& planes,
                                            const std::vector<Edge>& edges, FeatureType type,
                                            const FusionOptions& options) {
  options.Check();
  const int count = static_cast<int>(planes.size());
  const Ballot ballot = CollectVoters(planes, type, options.max_voters);
  const SearchIndex index = IndexOf(ballot, type, options);
  std::vector<std::map<int, int>> votes(count);
  tbb::parallel_for(0, count, [&](int p) {
    votes[p] = CountVotes(ballot, VotersOf(ballot, p), p, index, type, options);
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

std::vector<std::vector<int>> ProposeSightings(const std::vector<Plane>& planes,
                                               const std::vector<SampledKeyframe>& images,
                                               FeatureType type, const FusionOptions& options) {
  options.Check();
  const Ballot ballot = CollectVoters(planes, type, options.max_voters);
  const SearchIndex index = IndexOf(ballot, type, options);
  std::vector<std::vector<int>> candidates(images.size());
  tbb::parallel_for(size_t{0}, images.size(), [&](size_t i) {
    const Descriptors& voters = images[i].features.descriptors;
    for (const auto& [plane, n] : CountVotes(ballot, voters, kNobody, index, type, options)) {
      // An image votes with all features that are matched later, so too few votes mean too few
      // matches.
      if (n >= options.min_inliers) candidates[i].push_back(plane);
    }
  });
  return candidates;
}

}  // namespace waystone
