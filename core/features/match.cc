// SPDX-License-Identifier: Apache-2.0
#include "core/features/match.h"

#include <algorithm>
#include <array>

#include "core/base/error.h"
#include "core/features/distance.h"

namespace waystone {
namespace {

// Rows whose distances are taken at a time: their descriptors fit the first-level cache.
constexpr int kBlockRows = 256;

// Keeps the two nearest of what it is shown.
struct NearestTwo {
  Neighbour first;
  Neighbour second;

  void Offer(int row, int distance) {
    if (distance < first.distance) {
      second = first;
      first = {row, distance};
    } else if (distance < second.distance) {
      second = {row, distance};
    }
  }
};

void InsertSorted(Neighbour* best, int k, Neighbour candidate) {
  int place = k - 1;
  while (place > 0 && best[place - 1].distance > candidate.distance) {
    best[place] = best[place - 1];
    --place;
  }
  best[place] = candidate;
}

}  // namespace

void MatchOptions::Check() const {
  if (!(max_ratio > 0 && max_ratio <= 1)) {
    throw MapError(ErrorCode::kBadOptions,
                   "max_ratio is " + std::to_string(max_ratio) + "; give a number in (0, 1]");
  }
}

bool PassesRatio(FeatureType type, int nearest, int second, double max_ratio) {
  const double limit = type == FeatureType::kSift ? max_ratio * max_ratio : max_ratio;
  return nearest < limit * second;
}

std::vector<Match> MatchDescriptors(DescriptorsView a, DescriptorsView b, FeatureType type,
                                    const MatchOptions& options) {
  options.Check();
  const DistanceKernel distances = FastestKernel(type);
  std::vector<NearestTwo> of_a(a.rows());
  std::vector<Neighbour> of_b(b.rows());
  std::array<int32_t, kBlockRows> block;
  for (int start = 0; start < b.rows(); start += kBlockRows) {
    const int rows = std::min(kBlockRows, b.rows() - start);
    for (int i = 0; i < a.rows(); ++i) {
      distances(a.row(i), b.row(start), rows, b.bytes, block.data());
      for (int j = 0; j < rows; ++j) {
        of_a[i].Offer(start + j, block[j]);
        if (block[j] < of_b[start + j].distance) of_b[start + j] = {i, block[j]};
      }
    }
  }
  std::vector<Match> matches;
  for (int i = 0; i < a.rows(); ++i) {
    const NearestTwo& nearest = of_a[i];
    if (nearest.first.row < 0) continue;
    if (!PassesRatio(type, nearest.first.distance, nearest.second.distance, options.max_ratio)) {
      continue;
    }
    if (options.mutual && of_b[nearest.first.row].row != i) continue;
    matches.push_back({i, nearest.first.row, nearest.first.distance});
  }
  return matches;
}

std::vector<Neighbour> NearestNeighbours(DescriptorsView queries, DescriptorsView rows,
                                         FeatureType type, int k) {
  WS_CHECK(k >= 1, "k must be positive");
  const DistanceKernel distances = FastestKernel(type);
  std::vector<Neighbour> best(static_cast<size_t>(queries.rows()) * k);
  std::array<int32_t, kBlockRows> block;
  for (int start = 0; start < rows.rows(); start += kBlockRows) {
    const int count = std::min(kBlockRows, rows.rows() - start);
    for (int i = 0; i < queries.rows(); ++i) {
      Neighbour* of_query = best.data() + static_cast<size_t>(i) * k;
      distances(queries.row(i), rows.row(start), count, rows.bytes, block.data());
      for (int j = 0; j < count; ++j) {
        if (block[j] < of_query[k - 1].distance) InsertSorted(of_query, k, {start + j, block[j]});
      }
    }
  }
  return best;
}

}  // namespace waystone
