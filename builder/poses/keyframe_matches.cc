// SPDX-License-Identifier: Apache-2.0
#include "builder/poses/keyframe_matches.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <set>

#include "core/base/check.h"
#include "localizer/planes/shortlist.h"

namespace waystone {
namespace {

constexpr int kNeighbours = 8;
constexpr int kRevisits = 20;
constexpr int kMinMatches = 15;

using Pairs = std::set<std::pair<int, int>>;

void AddNeighbours(const std::vector<Keyframe>& keyframes, Pairs& pairs) {
  const int count = static_cast<int>(keyframes.size());
  for (int a = 0; a < count; ++a) {
    for (int b = a + 1; b < count && b <= a + kNeighbours; ++b) {
      const bool together = keyframes[a].sequence == keyframes[b].sequence &&
                            keyframes[a].stretch == keyframes[b].stretch;
      if (together) pairs.insert({a, b});
    }
  }
}

void AddRevisits(const MapIndex& index, const std::vector<SampledKeyframe>& features,
                 Pairs& pairs) {
  PlaneQueryOptions query;
  query.max_keyframes = kRevisits;
  std::vector<Shortlist> proposed(features.size());
  tbb::parallel_for(size_t{0}, features.size(), [&](size_t i) {
    proposed[i] = VoteForPlaces(index, features[i].features, query);
  });
  for (int a = 0; a < std::ssize(proposed); ++a) {
    for (const ShortlistedKeyframe& other : proposed[a].keyframes) {
      if (other.keyframe != a) pairs.insert(std::minmax(a, other.keyframe));
    }
  }
}

}  // namespace

std::optional<VerifiedMatches> MatchImages(const Features& a, const Features& b,
                                           const MatchOptions& match,
                                           const EpipolarOptions& epipolar) {
  const std::vector<Match> matches = MatchDescriptors(a.descriptors, b.descriptors, a.type, match);
  std::vector<Eigen::Vector2d> in_a;
  std::vector<Eigen::Vector2d> in_b;
  for (const Match& found : matches) {
    in_a.push_back(PositionOf(a.keypoints[found.a]));
    in_b.push_back(PositionOf(b.keypoints[found.b]));
  }
  auto fit = FindEpipolarGeometry(in_a, in_b, epipolar);
  if (!fit) return std::nullopt;
  VerifiedMatches verified;
  for (const int row : fit->inliers) {
    verified.features.emplace_back(matches[row].a, matches[row].b);
  }
  verified.fit = std::move(*fit);
  return verified;
}

std::vector<MatchedKeyframes> MatchKeyframes(const MapIndex& index,
                                             const std::vector<SampledKeyframe>& features,
                                             const ProgressCallback& progress) {
  WS_CHECK(features.size() == index.map().keyframes.size(), "features of some keyframes only");
  Pairs pairs;
  AddNeighbours(index.map().keyframes, pairs);
  AddRevisits(index, features, pairs);
  const std::vector<std::pair<int, int>> todo(pairs.begin(), pairs.end());
  std::vector<MatchedKeyframes> matched(todo.size());
  ProgressReporter reporter(progress);
  std::atomic<int> done = 0;
  tbb::parallel_for(size_t{0}, todo.size(), [&](size_t i) {
    const auto [a, b] = todo[i];
    auto matches = MatchImages(features[a].features, features[b].features, {}, {});
    if (matches) matched[i] = {a, b, std::move(*matches)};
    reporter.Report("matches", ++done, static_cast<int>(todo.size()));
  });
  std::erase_if(matched, [&](const MatchedKeyframes& pair) {
    return std::ssize(pair.matches.features) < kMinMatches;
  });
  return matched;
}

}  // namespace waystone
