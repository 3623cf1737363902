// SPDX-License-Identifier: Apache-2.0
#include "core/manhattan/edge_chains.h"

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "core/geometry/linear_algebra.h"

namespace waystone {
namespace {

// The eight pixels around one, clockwise from the right.
constexpr std::array<std::array<int, 2>, 8> kAround{
    {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}}};
// Turns from the last step, in eighths, straight on first; never more than a right angle.
constexpr std::array<int, 5> kTurns{0, 1, -1, 2, -2};

bool IsEdge(const cv::Mat& left, const cv::Point& at) {
  return at.x >= 0 && at.y >= 0 && at.x < left.cols && at.y < left.rows && left.at<uchar>(at) != 0;
}

std::optional<int> NextStep(const cv::Mat& left, const cv::Point& at, int heading) {
  for (const int turn : kTurns) {
    const int step = (heading + turn + 8) % 8;
    if (IsEdge(left, at + cv::Point(kAround[step][0], kAround[step][1]))) return step;
  }
  return std::nullopt;
}

// Walks from a pixel and erases the pixels on its way from the image.
EdgeChain FollowEdge(cv::Mat& left, cv::Point at, int heading) {
  EdgeChain chain;
  while (const auto step = NextStep(left, at, heading)) {
    heading = *step;
    at += cv::Point(kAround[heading][0], kAround[heading][1]);
    left.at<uchar>(at) = 0;
    chain.push_back(at);
  }
  return chain;
}

EdgeChain ChainThrough(cv::Mat& left, const cv::Point& start) {
  left.at<uchar>(start) = 0;
  int first = 0;
  while (first < 8 && !IsEdge(left, start + cv::Point(kAround[first][0], kAround[first][1]))) {
    ++first;
  }
  if (first == 8) return {start};
  const EdgeChain ahead = FollowEdge(left, start, first);
  const EdgeChain behind = FollowEdge(left, start, (first + 4) % 8);
  EdgeChain chain(behind.rbegin(), behind.rend());
  chain.push_back(start);
  chain.insert(chain.end(), ahead.begin(), ahead.end());
  return chain;
}

Eigen::Vector2d ToVector(const cv::Point& point) { return {point.x, point.y}; }

// Index of the pixel farthest from the chord and its distance from it.
std::pair<int, double> Farthest(std::span<const cv::Point> chain) {
  const Eigen::Vector2d start = ToVector(chain.front());
  const Eigen::Vector2d chord = ToVector(chain.back()) - start;
  const double length = chord.norm();
  std::pair<int, double> farthest{0, 0.0};
  for (size_t i = 1; i < chain.size(); ++i) {
    const Eigen::Vector2d offset = ToVector(chain[i]) - start;
    const double distance = length > 0
                                ? std::abs(chord.x() * offset.y() - chord.y() * offset.x()) / length
                                : offset.norm();
    if (distance > farthest.second) farthest = {static_cast<int>(i), distance};
  }
  return farthest;
}

// Total least squares over the pixels, cut off at the first and last one.
ImageSegment FitLine(std::span<const cv::Point> chain) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const cv::Point& point : chain) mean += ToVector(point);
  mean /= static_cast<double>(chain.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const cv::Point& point : chain) {
    const Eigen::Vector2d offset = ToVector(point) - mean;
    scatter += offset * offset.transpose();
  }
  const Eigen::Vector2d along = DecomposeSymmetric(scatter).vectors.col(1);
  const auto foot = [&](const cv::Point& point) -> Eigen::Vector2d {
    return mean + along * along.dot(ToVector(point) - mean);
  };
  return {foot(chain.front()), foot(chain.back())};
}

void Cut(std::span<const cv::Point> chain, double max_bend_px, double min_length_px,
         std::vector<ImageSegment>& pieces) {
  if (static_cast<double>(chain.size()) < min_length_px / std::sqrt(2.0)) return;
  const auto [farthest, distance] = Farthest(chain);
  if (distance > max_bend_px) {
    Cut(chain.first(farthest + 1), max_bend_px, min_length_px, pieces);
    Cut(chain.subspan(farthest), max_bend_px, min_length_px, pieces);
    return;
  }
  const ImageSegment piece = FitLine(chain);
  if (piece.length_px() >= min_length_px) pieces.push_back(piece);
}

}  // namespace

std::vector<EdgeChain> LinkEdges(const cv::Mat& edges) {
  cv::Mat left = edges.clone();
  std::vector<EdgeChain> chains;
  for (int y = 0; y < left.rows; ++y) {
    for (int x = 0; x < left.cols; ++x) {
      if (left.at<uchar>(y, x) != 0) chains.push_back(ChainThrough(left, {x, y}));
    }
  }
  return chains;
}

std::vector<ImageSegment> StraightPieces(const std::vector<EdgeChain>& chains, double max_bend_px,
                                         double min_length_px) {
  std::vector<ImageSegment> pieces;
  for (const EdgeChain& chain : chains) Cut(chain, max_bend_px, min_length_px, pieces);
  return pieces;
}

}  // namespace waystone
