// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <numbers>

#include "builder/planes/landmarks.h"
#include "core/base/options.h"
#include "core/features/match.h"
#include "core/homography/segment_planes.h"
#include "core/search/inverted_file.h"

namespace waystone {

// Frames that only rotate (all matches fit one rotation) can't show planes.
struct RotationOptions {
  double min_share = 0.85;
  double max_excess = 1.3;
  double min_focal = 0.5;
  double max_focal = 3.0;
  int focal_steps = 60;
  double max_angle_rad = 1.0;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"min_share", &RotationOptions::min_share, OpenLow(0, 1), "",
                    "Share of the matches that one homography must explain before a pure rotation "
                    "is tested for."},
        OptionField{
            "max_excess", &RotationOptions::max_excess, AtLeast(1), "",
            "Maximum root-mean-square error of a rotation, relative to that of the unconstrained "
            "homography. Higher values treat more pairs of keyframes as rotations.",
            OptionUse::kInternal},
        OptionField{"min_focal", &RotationOptions::min_focal, Above(0), "image sizes",
                    "Minimum focal length tried if the camera is unknown, in units of the image's "
                    "longer side."},
        OptionField{"max_focal", &RotationOptions::max_focal, Above(0), "image sizes",
                    "Maximum focal length tried; above min_focal."},
        OptionField{"focal_steps", &RotationOptions::focal_steps, Closed(2, 10'000), "",
                    "Number of focal lengths tried.", OptionUse::kInternal},
        OptionField{
            "max_angle_rad", &RotationOptions::max_angle_rad, Open(0, std::numbers::pi / 2), "rad",
            "Matches farther than this from the optical axis of a calibrated camera are ignored: "
            "after undistortion, the edges of a very wide image are mostly noise."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// Fusion of planes seen again (sec. III-A).
struct FusionOptions {
  int min_votes = 5;
  int votes_per_feature = 4;
  int neighbours = 16;
  double max_vote_distance = 0.25;
  double max_vote_ratio = 0.8;
  int max_voters = 400;
  // How the voters are indexed: coarser than a map's own index, since it is used only once.
  InvertedFileOptions index = {.training_rows = 16, .rounds = 4};
  int probes = 24;
  int min_inliers = 14;
  double min_support = 0.5;
  double min_overlap = 0.25;
  double min_within_reach = 0.9;
  double max_moved_px = 2.0;
  double max_apart_px = 2.0;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionGroup{"index", &FusionOptions::index},
        OptionField{"min_votes", &FusionOptions::min_votes, AtLeast(1), "",
                    "Number of descriptor votes that make a pair of planes a candidate. Lower "
                    "values try more pairs."},
        OptionField{"votes_per_feature", &FusionOptions::votes_per_feature, Closed(1, 1000), "",
                    "Number of planes that a feature votes for, nearest first.",
                    OptionUse::kInternal},
        OptionField{"neighbours", &FusionOptions::neighbours, Closed(2, 1000), "",
                    "Number of nearest neighbours searched for per feature. The distance of the "
                    "farthest one is taken as that of a chance match.",
                    OptionUse::kInternal},
        OptionField{"max_vote_distance", &FusionOptions::max_vote_distance, OpenLow(0, 1), "",
                    "Maximum descriptor distance of a neighbour that counts, relative to the "
                    "largest possible one of its type. Higher values try more pairs."},
        OptionField{"max_vote_ratio", &FusionOptions::max_vote_ratio, OpenLow(0, 1), "",
                    "Maximum distance of a neighbour that counts, relative to that of a chance "
                    "match. A neighbour within either limit counts."},
        OptionField{"max_voters", &FusionOptions::max_voters, AtLeast(1), "",
                    "Number of features per plane that vote, most often seen first; bounds the "
                    "cost of large planes.",
                    OptionUse::kInternal},
        OptionField{"probes", &FusionOptions::probes, AtLeast(1), "",
                    "Number of lists of the voters' index that are searched. More lists miss fewer "
                    "neighbours, but take longer.",
                    OptionUse::kInternal},
        OptionField{
            "min_inliers", &FusionOptions::min_inliers, AtLeast(5), "",
            "Minimum number of matches that must support the homography between the two planes."},
        OptionField{"min_support", &FusionOptions::min_support, Closed(0, 1), "",
                    "Minimum share of all matches between the two planes that must support their "
                    "homography (\"most of the matches\")."},
        OptionField{"min_overlap", &FusionOptions::min_overlap, Closed(0, 1), "",
                    "Minimum share of a plane's features in the area common to both planes that "
                    "must match; of the two planes, the one with the larger share counts. This "
                    "keeps copies of a poster apart, which match only on the poster."},
        OptionField{"min_within_reach", &FusionOptions::min_within_reach, Closed(0, 1), "",
                    "Minimum share of a plane's features that must lie within reach of the other "
                    "plane's reference image. Otherwise the planes are connected by an edge "
                    "instead of being fused."},
        OptionField{"max_moved_px", &FusionOptions::max_moved_px, Above(0), "px",
                    "A feature is out of reach where the uncertainty of the homography (one "
                    "sigma) moves it by more than this."},
        OptionField{"max_apart_px", &FusionOptions::max_apart_px, Above(0), "px",
                    "Planes seen together are parts of one surface if their homographies map each "
                    "other's features to positions no farther apart than this (median), from any "
                    "keyframe with both in view to any other."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// How planes are found, followed and fused.
struct PlaneLayerOptions {
  MatchOptions match;
  SegmentationOptions segmentation;
  RotationOptions rotation;
  FusionOptions fusion;
  LandmarkOptions landmarks;
  int min_tracked = 8;
  double min_support = 0.5;
  double reacquire_px = 3.0;
  double reacquire_distance = 0.4;
  double max_extrapolation = 0.05;
  double min_anchored = 0.5;
  double min_vote_share = 0.6;
  int plenty_of_features = 150;
  int votes_in_plenty = 3;
  int min_features = 16;
  int min_features_unconfirmed = 40;
  uint64_t seed = 1;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionGroup{"match", &PlaneLayerOptions::match},
        OptionGroup{"segmentation", &PlaneLayerOptions::segmentation},
        OptionGroup{"rotation", &PlaneLayerOptions::rotation},
        OptionGroup{"fusion", &PlaneLayerOptions::fusion},
        OptionGroup{"landmarks", &PlaneLayerOptions::landmarks},
        OptionField{"min_tracked", &PlaneLayerOptions::min_tracked, AtLeast(5), "",
                    "Number of features of a plane that must be tracked into the next keyframe; "
                    "with fewer, the plane is closed."},
        OptionField{"min_support", &PlaneLayerOptions::min_support, Closed(0, 1), "",
                    "Minimum share of the matches between a plane's features and later keyframes "
                    "that must support the plane (\"most of the matches\"); with fewer, the plane "
                    "is dropped. Higher values give fewer, purer planes; lower values give more "
                    "planes, some of which mix different depths."},
        OptionField{"reacquire_px", &PlaneLayerOptions::reacquire_px, Above(0), "px",
                    "A keypoint within this distance of where the homography maps a feature may be "
                    "that feature.",
                    OptionUse::kInternal},
        OptionField{"reacquire_distance", &PlaneLayerOptions::reacquire_distance, OpenLow(0, 1), "",
                    "Maximum descriptor distance of such a keypoint, relative to the largest "
                    "possible one of its type.",
                    OptionUse::kInternal},
        OptionField{"max_extrapolation", &PlaneLayerOptions::max_extrapolation, AtLeast(0),
                    "image sizes",
                    "How far a plane may grow beyond its reference image; farther out, positions "
                    "are extrapolated and inaccurate."},
        OptionField{"min_anchored", &PlaneLayerOptions::min_anchored, Closed(0, 1), "",
                    "A plane is continued by a new one with a newer reference image if its own "
                    "reference image contains less than this share of its matches. Higher values "
                    "give more planes, each more accurate; lower values give fewer, larger ones."},
        OptionField{"min_vote_share", &PlaneLayerOptions::min_vote_share, Closed(0, 1), "",
                    "A feature is kept if it was found in at least this share of the keyframes in "
                    "which it should be visible."},
        OptionField{"plenty_of_features", &PlaneLayerOptions::plenty_of_features, AtLeast(4), "",
                    "A plane stores features that were found in fewer than votes_in_plenty "
                    "keyframes only up to this total. Lower values give smaller maps, faster "
                    "queries and fewer inliers per answer."},
        OptionField{"votes_in_plenty", &PlaneLayerOptions::votes_in_plenty, AtLeast(0), "",
                    "Number of keyframes in which a feature beyond plenty_of_features must have "
                    "been found."},
        OptionField{"min_features", &PlaneLayerOptions::min_features, AtLeast(4), "",
                    "A plane with fewer features after voting is dropped."},
        OptionField{"min_features_unconfirmed", &PlaneLayerOptions::min_features_unconfirmed,
                    AtLeast(4), "",
                    "The same as min_features, for a plane that no triple match confirms."},
        OptionField{"seed", &PlaneLayerOptions::seed, AnyValue(), "",
                    "Random seed of the samples."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

}  // namespace waystone
