// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/geometry/pose2.h"
#include "core/panorama/visual_compass.h"
#include "core/two_view/bearings.h"
#include "localizer/appearance/panorama_query_options.h"
#include "localizer/index/map_index.h"
#include "localizer/verdict/answer.h"
#include "localizer/verdict/appearance_verdict.h"
#include "localizer/verdict/deadline.h"

// Steps of LocatePanorama: for localizer/ and the calibration. All are pure (up to the deadline);
// thread-safe.
namespace waystone {

// A node that a query was compared with.
struct ComparedNode {
  int node = -1;           // index in the layer's nodes
  double cost = 0;         // of appearance: distance and disagreement of the phases
  double heading_rad = 0;  // of the query in the layer's frame, if it is there
  double sigma_rad = 0;
  int inliers = 0;  // of the relative pose; 0 when it wasn't accepted or looked for
  // Median angle between the node's and the query's rays of the inliers, without the turn.
  double parallax_rad = 0;
  // Direction from the node to the query in the layer's frame; known only with inliers.
  double direction_rad = 0;
  std::optional<Eigen::Matrix3d> query_from_node;  // the rotation; known only with inliers
};

// The nodes nearest by signature, ranked again by cost: best first, ties by node.
std::vector<ComparedNode> CompareByAppearance(const MapIndex& index, const FourierSignature& query,
                                              const PanoramaQueryOptions& options,
                                              const std::vector<bool>& left_out);

// Nodes ranked again by the inliers of relative poses, which are estimated for the nodes with the
// most matches. Nodes that aren't reached before the deadline have none.
std::vector<ComparedNode> VerifyByFeatures(const MapIndex& index, const BearingFeatures& query,
                                           std::vector<ComparedNode> nodes,
                                           const PanoramaQueryOptions& options,
                                           const Deadline& deadline = {});

// A panorama described as the layer's own are.
struct PanoramaQuery {
  FourierSignature signature;
  std::optional<BearingFeatures> features;  // if the layer's nodes have some and options.verify
};

// CompareByAppearance, then VerifyByFeatures where the query has features. Best first; empty when
// no node is left.
std::vector<ComparedNode> CompareQuery(const MapIndex& index, const PanoramaQuery& query,
                                       const PanoramaQueryOptions& options,
                                       const std::vector<bool>& left_out);

// A reference to a node for answers.
NodeRef RefOf(const MapIndex& index, const AppearanceNode& node);

// Whether two nodes are too far apart to be one place, or on different floors where both have
// poses.
bool AreElsewhere(const MapIndex& index, int a, int b, const PanoramaQueryOptions& options);

struct PlacedQuery {
  Pose2 pose;                                            // in the layer's frame
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // of the position
  double sigma = 0;                                      // along its worst direction
};

// The position among the nodes that agree with nodes[at]; its heading is the pose's.
PlacedQuery PlaceQuery(const MapIndex& index, const std::vector<ComparedNode>& nodes,
                       const PanoramaQueryOptions& options, size_t at = 0);

// Puts PlaceQuery into an answer, with the nearest node: of those that agree with nodes[at], the
// one that differs least from the query.
void TakePlace(const MapIndex& index, const std::vector<ComparedNode>& nodes,
               const PanoramaQueryOptions& options, size_t at, PanoramaAnswer& panorama);

// The evidence for nodes[at] as the place.
AppearanceEvidence CollectEvidence(const MapIndex& index, const std::vector<ComparedNode>& nodes,
                                   size_t at, const PanoramaQueryOptions& options);

}  // namespace waystone
