// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/base/ids.h"
#include "localizer/verdict/gates.h"

// Why a query got its answer: what became of every shortlisted plane.
namespace waystone {

// The gates that a shortlisted plane has to pass, in this order. The first that it fails stops it.
enum class Gate {
  kPassed,
  kSettled,         // not tried: a plane elsewhere had settled where the query is
  kNoHomography,    // no homography fits any matches
  kMinInliers,      // GateOptions::min_inliers
  kMinInlierShare,  // GateOptions::min_inlier_share
  kMaxScale,        // GateOptions::max_scale
};
// "passed", "settled", "no_homography", "min_inliers", "min_inlier_share", "max_scale".
// Thread-safe.
const char* NameOf(Gate gate);

// A plane of the shortlist.
struct ExplainedCandidate {
  PlaneId plane;
  KeyframeId reference;  // whose pixels the plane's are
  int votes = 0;         // features of the query that have the plane among their nearest
  int matches = 0;       // between the query and the plane; 0 where none were looked for
  int distinct = 0;      // inliers at distinct positions of the query
  Gate stopped_by = Gate::kPassed;
  int place = -1;  // index in Explanation::places; -1 for a plane that was stopped
  // The inliers, row by row: pixels of the query and of the reference image.
  std::vector<Eigen::Vector2d> query_points;
  std::vector<Eigen::Vector2d> reference_points;
};

// A keyframe that was verified by all its matches.
struct ExplainedKeyframe {
  KeyframeId keyframe;
  int matches = 0;
  int inliers = 0;      // at distinct positions of the query
  int independent = 0;  // of the inliers (CountIndependent)
  int expected = 0;     // features of the keyframe that the query should show (VerifiedKeyframe)
  double coverage = 0;  // share of the query near an inlier (ComputeCoverage)
  int place = -1;       // index in Explanation::places; -1 for one that is in none
  // The inliers, row by row: pixels of the query and of the keyframe.
  std::vector<Eigen::Vector2d> query_points;
  std::vector<Eigen::Vector2d> keyframe_points;
};

// Planes that passed and agree with each other.
struct ExplainedPlace {
  KeyframeId nearest;
  std::vector<PlaneId> planes;  // most inliers first
  int inliers = 0;
  double best_share = 0;   // of the best plane's matches that are inliers
  double probability = 0;  // that the place is right, in [0, 1]
};

struct Explanation {
  int width = 0;  // of the query, px
  int height = 0;
  int features = 0;
  GateOptions gates;                           // the limits that were applied
  std::vector<ExplainedCandidate> candidates;  // in the shortlist's order: most votes first
  std::vector<ExplainedKeyframe> keyframes;    // most inliers first; none without landmarks
  std::vector<ExplainedPlace> places;          // as JoinKeyframes sorts them
};

}  // namespace waystone
