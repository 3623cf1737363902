// SPDX-License-Identifier: Apache-2.0
#include "bench/baseline/image_graph.h"

#include <tbb/parallel_for.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>

#include "core/homography/homography.h"
#include "localizer/planes/spread.h"

namespace waystone::bench {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

// Whether the homography enlarges by less than `max_scale`, and turns nothing over, at a point.
bool ScalesSensibly(const Matrix3d& h, const Vector2d& x, double max_scale) {
  const double w = h.row(2).dot(x.homogeneous());
  const double area = h.determinant() / (w * w * w);
  return area > 1 / (max_scale * max_scale) && area < max_scale * max_scale;
}

// The homography of most matches between two images, not refined.
struct Verified {
  Matrix3d to_from = Matrix3d::Identity();
  PointPairs inliers;
  int distinct = 0;
};

// Nothing when a gate refuses it; `min_distinct` is the gate on inliers.
std::optional<Verified> Verify(const Features& from, const Features& to,
                               const std::vector<Match>& matches, int min_distinct,
                               const PlaneQueryOptions& options, uint64_t seed) {
  if (std::ssize(matches) < min_distinct) return std::nullopt;
  MatchedPoints points;
  for (const Match& match : matches) {
    points.from.push_back(PositionOf(from.keypoints[match.a]));
    points.to.push_back(PositionOf(to.keypoints[match.b]));
  }
  const auto fit = FindPlane(points, options.ransac, seed);
  if (!fit) return std::nullopt;
  Verified verified;
  verified.to_from = fit->model.to_from;
  for (int row : fit->inliers) verified.inliers.Add(points.from[row], points.to[row]);
  verified.distinct = CountApart(verified.inliers.a, options.gates.distinct_px);
  const bool passes =
      verified.distinct >= min_distinct &&
      verified.distinct >= options.gates.min_inlier_share * static_cast<double>(matches.size()) &&
      std::all_of(verified.inliers.a.begin(), verified.inliers.a.end(), [&](const Vector2d& x) {
        return ScalesSensibly(verified.to_from, x, options.gates.max_scale);
      });
  if (!passes) return std::nullopt;
  return verified;
}

std::optional<ImageEdge> Join(const ImageNode& a, const ImageNode& b,
                              const ImageGraphOptions& options) {
  const std::vector<Match> matches = MatchDescriptors(
      a.features.descriptors, b.features.descriptors, a.features.type, options.match);
  const uint64_t seed = options.localize.seed ^ (static_cast<uint64_t>(a.id.value) << 32) ^
                        static_cast<uint64_t>(b.id.value);
  const auto verified =
      Verify(a.features, b.features, matches, options.min_inliers, options.localize, seed);
  if (!verified) return std::nullopt;
  const auto refined = RefineHomography(verified->inliers, verified->to_from);
  if (!refined) return std::nullopt;
  return ImageEdge{a.id, b.id, verified->inliers.size(), refined->b_from_a};
}

// A node with its matches, waiting for its homography to be tried.
struct Candidate {
  int node = 0;
  std::vector<Match> matches;
};

std::vector<Candidate> ByMatches(const ImageGraph& graph, const Features& query,
                                 const MatchOptions& options) {
  std::vector<Candidate> candidates;
  for (int n = 0; n < static_cast<int>(graph.nodes.size()); ++n) {
    const Descriptors& descriptors = graph.nodes[n].features.descriptors;
    candidates.push_back(
        {n, MatchDescriptors(query.descriptors, descriptors, query.type, options)});
  }
  std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
    return a.matches.size() > b.matches.size();
  });
  return candidates;
}

}  // namespace

ImageGraph BuildImageGraph(std::vector<ImageNode> nodes, const ImageGraphOptions& options) {
  ImageGraph graph{std::move(nodes), {}};
  const int count = static_cast<int>(graph.nodes.size());
  std::vector<std::vector<ImageEdge>> edges_of(count);
  tbb::parallel_for(0, count, [&](int a) {
    for (int b = a + 1; b < count; ++b) {
      if (auto edge = Join(graph.nodes[a], graph.nodes[b], options)) edges_of[a].push_back(*edge);
    }
  });
  for (const auto& edges : edges_of) {
    graph.edges.insert(graph.edges.end(), edges.begin(), edges.end());
  }
  return graph;
}

ImageAnswer LocalizeInImages(const ImageGraph& graph, const Features& query,
                             const ImageGraphOptions& options) {
  const PlaneQueryOptions& localize = options.localize;
  ImageAnswer answer;
  std::optional<Verified> best;
  for (const Candidate& candidate : ByMatches(graph, query, localize.match)) {
    if (std::ssize(candidate.matches) < answer.inliers) break;
    ++answer.homographies_tried;
    const ImageNode& node = graph.nodes[candidate.node];
    auto verified = Verify(query, node.features, candidate.matches, options.min_inliers, localize,
                           localize.seed ^ static_cast<uint64_t>(node.id.value));
    if (!verified) continue;
    const bool wins = verified->distinct > answer.inliers ||
                      (verified->distinct == answer.inliers && candidate.node < answer.node);
    if (!wins) continue;
    answer.node = candidate.node;
    answer.inliers = verified->distinct;
    best = std::move(verified);
  }
  if (!best) return answer;
  const auto refined = RefineHomography(best->inliers, best->to_from);
  answer.node_from_query = refined ? refined->b_from_a : best->to_from;
  answer.query_points = std::move(best->inliers.a);
  return answer;
}

cv::Mat FloatDescriptors(const Features& features) {
  const Descriptors& bytes = features.descriptors;
  cv::Mat floats(bytes.rows(), bytes.bytes(), CV_32F);
  for (int i = 0; i < bytes.rows(); ++i) {
    std::copy(bytes.row(i), bytes.row(i) + bytes.bytes(), floats.ptr<float>(i));
  }
  return floats;
}

ImageAnswer LocalizeWithOpenCv(const ImageGraph& graph, const std::vector<cv::Mat>& descriptors,
                               const Features& query, const ImageGraphOptions& options) {
  const cv::Mat query_floats = FloatDescriptors(query);
  const cv::BFMatcher matcher(cv::NORM_L2);
  ImageAnswer answer;
  for (int n = 0; n < static_cast<int>(graph.nodes.size()); ++n) {
    std::vector<std::vector<cv::DMatch>> nearest;
    matcher.knnMatch(query_floats, descriptors[n], nearest, 2);
    std::vector<cv::Point2d> from;
    std::vector<cv::Point2d> to;
    for (const auto& two : nearest) {
      if (two.size() < 2 || two[0].distance >= options.localize.match.max_ratio * two[1].distance) {
        continue;
      }
      const Keypoint& a = query.keypoints[two[0].queryIdx];
      const Keypoint& b = graph.nodes[n].features.keypoints[two[0].trainIdx];
      from.emplace_back(a.x_px, a.y_px);
      to.emplace_back(b.x_px, b.y_px);
    }
    if (static_cast<int>(from.size()) < options.min_inliers) continue;
    ++answer.homographies_tried;
    std::vector<uint8_t> mask;
    const cv::Mat h =
        cv::findHomography(from, to, cv::RANSAC, options.localize.ransac.max_error_px, mask);
    const int inliers = static_cast<int>(std::count(mask.begin(), mask.end(), 1));
    if (h.empty() || inliers <= answer.inliers) continue;
    answer.node = n;
    answer.inliers = inliers;
    for (int i = 0; i < 9; ++i) answer.node_from_query(i / 3, i % 3) = h.at<double>(i / 3, i % 3);
    answer.query_points.clear();
    for (size_t i = 0; i < from.size(); ++i) {
      if (mask[i]) answer.query_points.emplace_back(from[i].x, from[i].y);
    }
  }
  if (answer.inliers < options.min_inliers) return {};
  return answer;
}

}  // namespace waystone::bench
