// SPDX-License-Identifier: Apache-2.0
#include "bench/baseline/vote_search.h"

#include <algorithm>
#include <numeric>
#include <opencv2/calib3d.hpp>

#include "core/features/match.h"

namespace waystone::bench {
namespace {

constexpr int kVerified = 5;
constexpr int kVoteMinInliers = 15;
constexpr double kHomographyError_px = 3;

SearchIndex MakeIndex(const Descriptors& rows, FeatureType type, int probes) {
  InvertedFileOptions options;
  options.min_rows = 1;
  SearchIndex index = probes == 0 ? SearchIndex(type, rows.rows())
                                  : SearchIndex(type, BuildInvertedFile(rows, type, options));
  for (int row = 0; row < rows.rows(); ++row) index.Set(row, rows.row(row));
  return index;
}

int CountHomographyInliers(const PackedRows& query_rows, const Features& query,
                           const Features& image) {
  std::vector<cv::Point2f> in_query;
  std::vector<cv::Point2f> in_image;
  for (const Match& match :
       MatchDescriptors(query_rows, query.size(), image.descriptors, MatchOptions{0.8, true})) {
    in_query.emplace_back(query.keypoints[match.a].x_px, query.keypoints[match.a].y_px);
    in_image.emplace_back(image.keypoints[match.b].x_px, image.keypoints[match.b].y_px);
  }
  if (std::ssize(in_query) < kVoteMinInliers) return 0;
  std::vector<uint8_t> is_inlier;
  cv::findHomography(in_query, in_image, cv::USAC_MAGSAC, kHomographyError_px, is_inlier);
  return static_cast<int>(std::ranges::count(is_inlier, 1));
}

}  // namespace

VoteSearch::VoteSearch(std::vector<Features> images, int probes)
    : images_(std::move(images)), probes_(std::max(1, probes)) {
  if (images_.empty()) return;
  Descriptors rows(images_.front().descriptors.bytes());
  for (size_t i = 0; i < images_.size(); ++i) {
    for (int row = 0; row < images_[i].size(); ++row) rows.Append(images_[i].descriptors.row(row));
    image_of_row_.resize(rows.rows(), static_cast<int>(i));
  }
  index_ = MakeIndex(rows, images_.front().type, probes);
}

std::vector<int> VoteSearch::MostVoted(const Features& query) const {
  std::vector<int> votes(images_.size(), 0);
  for (const Neighbour& nearest : index_.Nearest(query.descriptors, 1, probes_)) {
    if (nearest.row >= 0) ++votes[image_of_row_[nearest.row]];
  }
  std::vector<int> order(images_.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, [&](int a, int b) { return votes[a] > votes[b]; });
  order.resize(std::min<size_t>(order.size(), kVerified));
  return order;
}

std::optional<FoundImage> VoteSearch::Find(const Features& query) const {
  if (query.size() == 0) return std::nullopt;
  const PackedRows rows(query.type, query.descriptors);
  FoundImage best;
  for (const int image : MostVoted(query)) {
    const int inliers = CountHomographyInliers(rows, query, images_[image]);
    if (inliers > best.inliers) best = {image, inliers};
  }
  if (best.inliers < kVoteMinInliers) return std::nullopt;
  return best;
}

int64_t VoteSearch::CountBytes() const {
  int64_t bytes = 0;
  for (const Features& image : images_) {
    bytes += static_cast<int64_t>(image.size()) * (image.descriptors.bytes() + 4);
  }
  return bytes;
}

}  // namespace waystone::bench
