// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "core/base/ids.h"
#include "core/features/features.h"
#include "core/features/match.h"
#include "core/homography/find_plane.h"
#include "localizer/options.h"

// The graph that the plane graph is measured against: images as nodes, with all features, an edge
// where a homography joins two images, localization against every image. Written to be fast at
// this: the same features, matching kernels, RANSAC and gates as ours, all cores when building, and
// no search for a homography that could change nothing.
namespace waystone::bench {

struct ImageNode {
  KeyframeId id;
  int frame = 0;  // in its sequence
  Features features;

  bool operator==(const ImageNode& other) const {
    return id == other.id && frame == other.frame && features.type == other.features.type &&
           features.width == other.features.width && features.height == other.features.height &&
           features.keypoints == other.features.keypoints &&
           features.descriptors == other.features.descriptors;
  }
};

// Two images with a homography between them: x_b = b_from_a x_a, h33 = 1; a < b.
struct ImageEdge {
  KeyframeId a;
  KeyframeId b;
  int inliers = 0;
  Eigen::Matrix3d b_from_a = Eigen::Matrix3d::Identity();

  bool operator==(const ImageEdge&) const = default;
};

struct ImageGraph {
  std::vector<ImageNode> nodes;  // by id
  std::vector<ImageEdge> edges;  // by (a, b)

  bool operator==(const ImageGraph&) const = default;
};

struct ImageGraphOptions {
  MatchOptions match;  // between images of the graph: as the plane tracker's
  // Matching of queries, RANSAC, gates and seed: as the localizer's.
  PlaneQueryOptions localize;
  // Inliers at distinct positions that an edge or an answer needs: an image graph has no calibrated
  // verdict.
  int min_inliers = 15;
};

// Compares every image with every other on all threads of the calling arena. Edges: those whose
// homography passes the gates of a recognised plane. The same on any number of threads.
ImageGraph BuildImageGraph(std::vector<ImageNode> nodes, const ImageGraphOptions& options);

// The image that a query shows.
struct ImageAnswer {
  int node = -1;  // in ImageGraph::nodes; -1 when none passes the gates
  int inliers = 0;
  Eigen::Matrix3d node_from_query = Eigen::Matrix3d::Identity();  // h33 = 1
  std::vector<Eigen::Vector2d> query_points;                      // the inliers' pixels
  int homographies_tried = 0;
};

// Matches a query with every image; the image with the most distinct inliers of a homography that
// passes the gates of a place wins, the earlier one among equals. On the calling thread. Images are
// tried by descending number of matches; an image that has no more matches than the best one has
// inliers can't win, which saves time and doesn't change the answer.
ImageAnswer LocalizeInImages(const ImageGraph& graph, const Features& query,
                             const ImageGraphOptions& options);

// The same as people would write it with OpenCV only: cv::BFMatcher on float descriptors, ratio
// test, cv::findHomography with RANSAC, most inliers win. `descriptors` are FloatDescriptors of the
// nodes.
ImageAnswer LocalizeWithOpenCv(const ImageGraph& graph, const std::vector<cv::Mat>& descriptors,
                               const Features& query, const ImageGraphOptions& options);

// Descriptors as 32-bit floats, one row each.
cv::Mat FloatDescriptors(const Features& features);

}  // namespace waystone::bench
