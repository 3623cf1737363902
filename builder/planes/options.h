// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "core/features/match.h"
#include "core/homography/segment_planes.h"
#include "core/search/inverted_file.h"

namespace waystone {

// Frames that only rotate (all matches fit one rotation) can't show planes.
struct RotationOptions {
  // Share of the matches that one homography must explain before a rotation is tried at all.
  double min_share = 0.85;
  // How much worse than the free homography (root mean square) a rotation may fit and still be it.
  double max_excess = 1.3;
  // Focal lengths tried where the camera isn't known, as shares of the image's longer side.
  double min_focal = 0.5;
  double max_focal = 3.0;
  int focal_steps = 60;
  // Where the camera is known, matches farther than this from its optical axis don't count: made
  // straight, the edge of a very wide image is mostly noise. rad, below a right angle
  double max_angle_rad = 1.0;

  void Check() const;  // throws MapError(kBadOptions)
};

// Fusion of planes seen again (sec. III-A).
struct FusionOptions {
  // Descriptor votes that make a pair of planes a candidate. Lower tries more pairs.
  int min_votes = 5;
  // Planes that a feature votes for, nearest first.
  int votes_per_feature = 4;
  // Neighbours of a feature that are looked at. The farthest of them says how near descriptors come
  // to it by chance.
  int neighbours = 16;
  // A neighbour counts that is at most this far, as a share of the largest distance of its type ...
  double max_vote_distance = 0.25;
  // ... or at most this far in relation to what is there by chance. Both higher: more votes for
  // planes that are worse to see, and more by chance, so that more pairs have to be tried.
  double max_vote_ratio = 0.8;
  // Features a plane, best seen first, that vote. Bounds the cost on large planes.
  int max_voters = 400;
  // How the voters are sorted for searching: coarser than a map's own index, it is used only once.
  InvertedFileOptions index = {.training_rows = 16, .rounds = 4};
  // Lists of it that are searched. More miss fewer neighbours and take longer.
  int probes = 24;
  // Matches that must support the homography between the two planes ...
  int min_inliers = 14;
  // ... and the share of all matches between them ("most of the matches").
  double min_support = 0.5;
  // Of the features that lie where both planes were seen, the share that must be found in both.
  // The same wall is recognised all over; a poster hung twice is recognised on the poster alone.
  double min_overlap = 0.25;
  // Share of a plane's features that the other one's reference image must reach. Fused beyond that,
  // they would be extrapolated; the planes stay two and are joined by an edge instead.
  double min_within_reach = 0.9;
  // A feature counts as out of reach too where the noise of the homography between the two planes
  // moves it by more than this (a standard deviation): what supports it may be far away. px
  double max_moved_px = 2.0;

  void Check() const;  // throws MapError(kBadOptions)
};

struct PlaneLayerOptions {
  MatchOptions match;
  SegmentationOptions segmentation;
  RotationOptions rotation;
  FusionOptions fusion;
  // Features that must follow a plane into the next keyframe; with fewer it is closed.
  int min_tracked = 8;
  // A keypoint is a feature of the plane again if it lies this close to where the homography puts
  // it. px
  double reacquire_px = 3.0;
  // ... and its descriptor is at most this far, as a share of the largest distance of its type.
  double reacquire_distance = 0.4;
  // A plane reaches this many image sizes beyond its reference image: farther out, positions are
  // extrapolated and mean little, and what a plane would grow by becomes a plane of its own.
  double max_extrapolation = 0.05;
  // A plane whose matches are features that its reference image shows by less than this share is
  // taken up by a new plane with a newer reference image. Higher: more planes, each truer to its
  // reference image; lower: fewer and larger ones.
  double min_anchored = 0.5;
  // A feature is kept if it was found in this share of the keyframes that should have seen it.
  double min_vote_share = 0.6;
  // A plane with more features than this keeps those that fewer than votes_in_plenty keyframes
  // found only up to it, those with most votes first. Lower: smaller maps and faster queries, at
  // fewer inliers an answer.
  int plenty_of_features = 150;
  int votes_in_plenty = 3;
  // A plane with fewer features left after the votes is dropped.
  int min_features = 16;
  // A plane that was started and lost again at once, so that no triple match ever confirmed it,
  // needs as many features as this.
  int min_features_unconfirmed = 40;
  uint64_t seed = 1;

  void Check() const;  // throws MapError(kBadOptions)
};

}  // namespace waystone
