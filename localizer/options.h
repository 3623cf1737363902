// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "core/features/match.h"
#include "core/homography/homology.h"
#include "core/homography/local_ransac.h"
#include "core/image/decode.h"

namespace waystone {

// The gates between a shortlisted plane and an answer.
struct GateOptions {
  // Distinct places in the image whose matches support a plane's homography. Higher refuses more
  // true planes, lower lets chance through.
  int min_inliers = 8;
  // The probability that a place is right, by the map's model (VerdictModel), from which on the
  // answer says so.
  double min_probability = 0.9;
  // Share of the plane's matches that must support its homography.
  double min_inlier_share = 0.2;
  // Inliers closer together than this count once: one corner gives several features. px
  double distinct_px = 4.0;
  // The homography may enlarge or shrink at most by this factor between query and reference. A
  // larger one is a fit through noise.
  double max_scale = 8.0;
  // A second place with this share of the first one's inliers makes the answer ambiguous.
  double ambiguous_share = 0.7;

  void Check() const;  // throws MapError(kBadOptions)
};

struct LocalizeOptions {
  DecodeLimits limits;
  // Features taken from a query; their type is the map's.
  int max_features = 1000;
  double contrast_threshold = 0.02;  // as FeatureOptions'
  // Nearest map features for which a query feature votes.
  int votes_per_feature = 3;
  // Lists of the map's search index in which they are looked for. More find more of the true
  // nearest and take longer; as many as there are lists find all.
  int probes = 64;
  // Planes whose homography is tried, best voted first. More find more and cost about 1 ms each.
  int max_candidates = 16;
  // A plane with this many distinct inliers settles where the query is: ...
  int settled_inliers = 30;
  // ... planes elsewhere in the map are tried after it only with this share of its inliers in
  // votes, below which they can't make the answer ambiguous. 0 tries all, which costs the most on
  // large maps.
  double settled_share = 0.5;
  // Fewer votes than this, and a plane isn't tried.
  int min_votes = 6;
  MatchOptions match{0.85, true};
  // A wider bound than for building, since a query's camera may be another one, and fewer samples:
  // most planes that are tried are wrong, and those cost the most.
  LocalRansacOptions ransac{.max_error_px = 3.0, .max_samples = 500};
  HomologyOptions homology;
  GateOptions gates;
  // Seed of the sampling: the same query, map and options give the same answer.
  uint64_t seed = 1;

  void Check() const;  // throws MapError(kBadOptions)
};

}  // namespace waystone
