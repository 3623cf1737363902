// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "core/camera/camera.h"
#include "core/features/match.h"
#include "core/geometry/pose2.h"
#include "core/homography/find_plane.h"
#include "core/homography/homology.h"
#include "core/image/decode.h"
#include "core/localization/graph_filter.h"
#include "core/manhattan/manhattan_frame.h"
#include "core/panorama/visual_compass.h"
#include "core/two_view/relative_rotation.h"
#include "localizer/appearance/panorama_features.h"

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

// When an answer is no use any more; nothing for never.
using Deadline = std::optional<std::chrono::steady_clock::time_point>;

inline bool HasPassed(const Deadline& deadline) {
  return deadline && std::chrono::steady_clock::now() >= *deadline;
}

// What a panorama is asked by.
struct PanoramaQueryOptions {
  // Nodes that are compared, nearest signature first, 1 to 1000: by their phases, and by their
  // features where they have some. More find more places and cost time, mostly of features.
  int candidates = 8;
  int verified_candidates = 16;
  // Weight of the phases' disagreement (0 to 1) beside the signatures' distance, 0 to 10. More
  // trusts what is seen at the same height and angle; less bears motion.
  double phase_weight = 0.5;
  // Few frequencies: places near each other agree in these alone.
  PhaseCompassOptions phases{.frequencies = 12, .steps = 128};
  // Whether the heading is refined by the warping search, which costs about 0.5 ms. Without it, it
  // is the phases', which is exact for a pure turn alone.
  bool fine_heading = true;
  CompassOptions compass;
  // Standard sigma of the phases' heading, 0.001 to 3, where it isn't refined.
  double phase_sigma_rad = 0.3;
  // Whether candidates are verified by features, where the nodes have some. Costs the extraction.
  bool verify = true;
  // An answer by appearance alone that is as probable isn't verified, 0.5 to 1 (all are). Less
  // answers faster and trusts the appearance more.
  double settled_probability = 0.99;
  PanoramaFeatureOptions features;
  MatchOptions match{0.8, true};
  // Candidates whose relative pose is looked for, most matches first, 1 to 1000.
  int max_poses = 4;
  // Features of a perspective photo, 10 to 100,000: more match more of what nodes keep.
  int photo_features = 1500;
  // Each of them votes for the nodes of so many nearest features, 2 to 1000, in so many lists of
  // the nodes' index, 1 to 32768: as many as see a place together. More find more and take longer.
  int photo_neighbours = 20;
  int photo_probes = 8;
  // Nodes that the photo is matched with, most voted first, 1 to 10,000. More find more places and
  // cost about 1 ms each.
  int photo_candidates = 64;
  RelativeOptions relative{.max_samples = 200};
  // Costs by which a neighbour counts e times less for the position, 0.001 to 10. More interpolates
  // more widely.
  double interpolation_cost = 0.1;
  // Standard sigma of a direction between two panoramas, 0.001 to 1. More trusts the nodes'
  // places instead.
  double direction_sigma_rad = 0.03;
  // Nodes farther apart than so many spacings are different places, 1 to 1000.
  double elsewhere_spacings = 4;
  // A margin beyond this says no more, 0.001 to 10.
  double max_margin = 0.3;
  // Headings of the query that two nodes see agree within this, 0.01 to 3. More lets chance speak
  // for a place.
  double agreement_rad = 0.25;
  // The probability from which on an answer is given, between 0 and 1. Higher refuses more.
  double min_probability = 0.9;

  void Check() const;  // throws MapError(kBadOptions)
};

// How a query's rotation in the building is found and checked.
struct BuildingOptions {
  SegmentOptions segments;
  GreatCircleOptions circles;
  ManhattanOptions manhattan;
  // The lines are believed when their best rival frame has at most this share of their support, 0
  // to 1. Higher believes more photos, and more that are wrong.
  double max_clear_rival = 0.6;
  // Angle by which believed lines may be off the axes that a place implies, above 0 to pi / 4.
  // Higher lets more wrong places pass. rad
  double max_disagreement_rad = 0.17;
  // Share of true places whose lines are believed and disagree all the same, between 0 and 1.
  // Higher refuses fewer answers.
  double true_disagreeing = 0.02;

  void Check() const;  // throws MapError(kBadOptions)
};

// What is known of a robot when a panorama of its series comes.
struct SeriesContext {
  FilterState previous;  // Answer::belief of the panorama before; empty for the first
  // The motion since then, previous_from_now in the layer's units, where it is known.
  std::optional<Pose2> odometry;
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
  PanoramaQueryOptions panorama;
  // A panorama is answered as the next one of a series with it, and by itself without.
  std::optional<SeriesContext> series;
  BuildingOptions building;
  // The camera of a perspective photo, where it is known: what a map of panoramas answers it by,
  // and what its rotation in the building takes.
  std::optional<Camera> camera;
  // Say in the answer what became of every shortlisted plane. Changes nothing else; makes the
  // answer some 50 KB larger.
  bool explain = false;
  // Seed of the sampling: the same query, map and options give the same answer.
  uint64_t seed = 1;
  // It is looked at between stages, between planes and between panoramas; the verdict is kUndecided
  // from then on. An answer depends on the machine's speed with it, and not without.
  Deadline deadline;

  // Whether there is a deadline and it has passed.
  bool TooLate() const { return HasPassed(deadline); }

  void Check() const;  // throws MapError(kBadOptions)
};

}  // namespace waystone
