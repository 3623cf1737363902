// SPDX-License-Identifier: Apache-2.0
#include "bench/baseline/image_search.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <numeric>

#include "core/features/match.h"
#include "core/two_view/fundamental.h"

namespace waystone::bench {
namespace {

constexpr int kSearchMinInliers = 15;
constexpr int kRepeatNeighbours = 2;
constexpr double kSearchError_px = 1.5;

// Matches that fit one epipolar geometry.
std::vector<Match> VerifyMatches(const PackedRows& a_rows, const Features& a, const Features& b) {
  const std::vector<Match> matches =
      MatchDescriptors(a_rows, a.size(), b.descriptors, MatchOptions{0.8, true});
  std::vector<Eigen::Vector2d> in_a;
  std::vector<Eigen::Vector2d> in_b;
  for (const Match& match : matches) {
    in_a.push_back(PositionOf(a.keypoints[match.a]));
    in_b.push_back(PositionOf(b.keypoints[match.b]));
  }
  // The planar share of 1 leaves degenerate geometries as they are.
  const auto fit = FindEpipolarGeometry(
      in_a, in_b, {.max_error_px = kSearchError_px, .max_samples = 1000, .planar_share = 1});
  std::vector<Match> inliers;
  if (!fit) return inliers;
  for (const int row : fit->inliers) inliers.push_back(matches[row]);
  return inliers;
}

Features KeepMostRepeated(const Features& features, const std::vector<int>& repeats, int kept) {
  std::vector<int> order(features.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, [&](int a, int b) { return repeats[a] > repeats[b]; });
  order.resize(std::min<size_t>(order.size(), kept));
  Features out = features;
  out.keypoints.clear();
  out.descriptors = Descriptors(features.descriptors.bytes());
  for (const int row : order) {
    out.keypoints.push_back(features.keypoints[row]);
    out.descriptors.Append(features.descriptors.row(row));
  }
  return out;
}

}  // namespace

ImageSearch::ImageSearch(std::vector<Features> images, int kept) : images_(std::move(images)) {
  const auto largest =
      std::ranges::max(images_, {}, [](const Features& image) { return image.size(); }).size();
  if (kept >= largest) return;
  std::vector<Features> reduced(images_.size());
  tbb::parallel_for(size_t{0}, images_.size(), [&](size_t i) {
    std::vector<int> repeats(images_[i].size(), 0);
    const PackedRows rows(images_[i].type, images_[i].descriptors);
    for (int step = -kRepeatNeighbours; step <= kRepeatNeighbours; ++step) {
      const int64_t other = static_cast<int64_t>(i) + step;
      if (step == 0 || other < 0 || other >= std::ssize(images_)) continue;
      for (const Match& match : VerifyMatches(rows, images_[i], images_[other])) {
        ++repeats[match.a];
      }
    }
    reduced[i] = KeepMostRepeated(images_[i], repeats, kept);
  });
  images_ = std::move(reduced);
}

std::optional<FoundImage> ImageSearch::Find(const Features& query) const {
  const PackedRows rows(query.type, query.descriptors);
  FoundImage best;
  for (size_t i = 0; i < images_.size(); ++i) {
    const auto inliers = static_cast<int>(VerifyMatches(rows, query, images_[i]).size());
    if (inliers > best.inliers) best = {static_cast<int>(i), inliers};
  }
  if (best.inliers < kSearchMinInliers) return std::nullopt;
  return best;
}

int64_t ImageSearch::CountFeatures() const {
  int64_t count = 0;
  for (const Features& image : images_) count += image.size();
  return count;
}

}  // namespace waystone::bench
