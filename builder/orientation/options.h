// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/options.h"
#include "core/manhattan/manhattan_frame.h"
#include "core/two_view/bearings.h"
#include "core/two_view/relative_rotation.h"

namespace waystone {

// How axes are followed from frame to frame.
struct FollowOptions {
  double max_jump_rad = 0.2;
  double max_clear_rival = 0.6;
  int min_votes = 5;
  double max_drift_rad = 0.09;
  double max_rival_drift_rad = 0.04;
  double step_sigma_rad = 0.001;
  int anchor_frames = 20;
  int retry_frames = 5;
  double clear_share = 0.5;
  double doubt_share = 0.15;
  int steady_frames = 10;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"max_jump_rad", &FollowOptions::max_jump_rad, Closed(0.01, 0.7), "rad",
                    "Maximum rotation between two consecutive frames. Where the features give no "
                    "rotation, it bounds how far the axes may have turned."},
        OptionField{"max_clear_rival", &FollowOptions::max_clear_rival, Closed(0, 1), "",
                    "A frame is accepted on its own if its best rival has at most this share of "
                    "its support. Higher values use the features less often, but accept more wrong "
                    "frames of single cameras."},
        OptionField{"min_votes", &FollowOptions::min_votes, Closed(1, 100), "frames",
                    "Number of consecutive frames that must agree before the axes are fixed if no "
                    "frame is clear."},
        OptionField{
            "max_drift_rad", &FollowOptions::max_drift_rad, Closed(0.01, 0.5), "rad",
            "Maximum angle between the axes of the lines and those that the features' rotation "
            "predicts. Higher values mistake the lines of a skewed room for the building's."},
        OptionField{"max_rival_drift_rad", &FollowOptions::max_rival_drift_rad, Closed(0.005, 0.5),
                    "rad",
                    "The same as max_drift_rad, if the lines allow several frames. Lower values "
                    "accept fewer frames of single cameras."},
        OptionField{"step_sigma_rad", &FollowOptions::step_sigma_rad, Closed(1e-5, 0.1), "rad",
                    "Standard deviation of a rotation between two frames, in addition to that of "
                    "its matches. Higher values trust the lines more and the features less."},
        OptionField{"anchor_frames", &FollowOptions::anchor_frames, Closed(1, 1000), "frames",
                    "Interval at which a frame is kept, to resolve the quarter turn after the axes "
                    "were lost. A shorter interval costs time."},
        OptionField{"retry_frames", &FollowOptions::retry_frames, Closed(1, 100), "frames",
                    "Interval at which frames without axes are compared with the kept ones. A "
                    "shorter interval costs time."},
        OptionField{
            "clear_share", &FollowOptions::clear_share, Open(0, 1), "",
            "One of two choices is accepted if its misfit is at most this share of the other's.",
            OptionUse::kInternal},
        OptionField{"doubt_share", &FollowOptions::doubt_share, Closed(0, 1), "",
                    "Standard deviation of a clear choice, as a share of the angle between the "
                    "two.",
                    OptionUse::kInternal},
        OptionField{
            "steady_frames", &FollowOptions::steady_frames, Closed(1, 1000), "frames",
            "Number of frames for which a camera may be assumed to keep turning at the same rate.",
            OptionUse::kInternal});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// Whether one frame can be reached in view from another (sec. II-B.2).
struct TraversabilityOptions {
  MatchOptions matching;
  // min_inliers is the paper's 10 correspondences. Where a plane allows two motions, the camera's
  // previous turn decides, so max_rival leaves only near ties to it.
  RelativeOptions relative{.max_rival = 0.98};
  double max_disagreement_rad = 0.087;
  double min_parallax_rad = 0.008;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionGroup{"matching", &TraversabilityOptions::matching},
        OptionGroup{"relative", &TraversabilityOptions::relative},
        OptionField{"max_disagreement_rad", &TraversabilityOptions::max_disagreement_rad,
                    Closed(0.005, 0.5), "rad",
                    "Maximum angle between the essential matrix's rotation and R1 R2^T, modulo "
                    "quarter turns. Higher values connect frames whose rotation is wrong."},
        OptionField{"min_parallax_rad", &TraversabilityOptions::min_parallax_rad,
                    Closed(0.0005, 0.5), "rad",
                    "Median angle by which inliers must move, in addition to the rotation, before "
                    "a direction of motion is accepted. Lower values give even a stationary camera "
                    "a direction."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// Turns (sec. II-B.1).
struct TurnOptions {
  double hysteresis_rad = 0.05;
  int reach = 5;
  double settled_rad = 0.35;
  int settled_motions = 3;
  bool use_motions = true;

  static constexpr auto Fields(const auto& use) {
    return use(OptionField{"hysteresis_rad", &TurnOptions::hysteresis_rad, Closed(0, 0.5), "rad",
                           "How far beyond half a right angle the heading must turn before the "
                           "axis is switched. Higher values keep a camera that looks along a "
                           "diagonal from switching back and forth."},
               OptionField{"reach", &TurnOptions::reach, Closed(1, 100), "frames",
                           "The test connects the frame this many frames before a jump with the "
                           "one the same number of frames after it."},
               OptionField{"settled_rad", &TurnOptions::settled_rad, Closed(0.05, 0.7), "rad",
                           "A motion whose heading is within this angle of an axis follows that "
                           "axis. Higher values settle earlier, but mistake trajectories across a "
                           "room for ones along an axis."},
               OptionField{"settled_motions", &TurnOptions::settled_motions, Closed(1, 100), "",
                           "Number of consecutive motions along the same axis before the "
                           "trajectory counts as following it. Higher values leave out short "
                           "detours and short stretches between two turns."},
               OptionField{
                   "use_motions", &TurnOptions::use_motions, AnyValue(), "",
                   "Whether turns are decided by the axes that the motion follows; false uses only "
                   "the paper's test, whether the frames before and after a jump are connected.",
                   OptionUse::kInternal});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// Corridors (sec. III-C.1).
struct CorridorOptions {
  double heading_range_rad = 0.35;
  double min_ratio = 1.33;
  int min_frames = 30;
  int max_gap_frames = 10;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"heading_range_rad", &CorridorOptions::heading_range_rad, Closed(0.05, 1.5),
                    "rad",
                    "Range of the heading within a corridor. Higher values tolerate more sway."},
        OptionField{"min_ratio", &CorridorOptions::min_ratio, Closed(1, 20), "",
                    "Minimum ratio of lines along the corridor to lines across it. Higher values "
                    "exclude rooms and wide halls."},
        OptionField{"min_frames", &CorridorOptions::min_frames, Closed(1, 100'000), "frames",
                    "Minimum length of a corridor."},
        OptionField{"max_gap_frames", &CorridorOptions::max_gap_frames, Closed(0, 1000), "frames",
                    "Maximum number of consecutive frames without a rotation in a corridor."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// Loop closures (sec. III-C.2): stricter than traversability, because places far apart may look
// alike.
struct OrientationLoopOptions {
  int min_gap_frames = 60;
  int sample = 600;
  int candidates = 4;
  int min_matches = 40;
  double max_log10_chance = -20;
  double max_turn_rad = 0.5;
  double max_disagreement_rad = 0.035;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionField{"min_gap_frames", &OrientationLoopOptions::min_gap_frames, Closed(1, 1'000'000),
                    "frames",
                    "Nodes of one sequence closer together than this are neighbours anyway and "
                    "form no loop."},
        OptionField{
            "sample", &OrientationLoopOptions::sample, Closed(10, 10'000), "",
            "Number of features of a node, strongest first, that are used to rank earlier nodes."},
        OptionField{"candidates", &OrientationLoopOptions::candidates, Closed(1, 1000), "",
                    "Number of best-ranked earlier nodes that are verified. Higher values find "
                    "weaker loops; time grows linearly."},
        OptionField{
            "min_matches", &OrientationLoopOptions::min_matches, Closed(5, 10'000), "",
            "Minimum number of verified correspondences for a loop (the paper's loop had 46)."},
        OptionField{"max_log10_chance", &OrientationLoopOptions::max_log10_chance, Closed(-300, 0),
                    "",
                    "Maximum number of motions, as a power of ten, that the same number of "
                    "unrelated matches would be expected to fit."},
        OptionField{"max_turn_rad", &OrientationLoopOptions::max_turn_rad, Closed(0.05, 3.2), "rad",
                    "Maximum difference between the two orientations."},
        OptionField{"max_disagreement_rad", &OrientationLoopOptions::max_disagreement_rad,
                    Closed(0.005, 0.5), "rad",
                    "Maximum angle between the essential matrix's rotation and R1 R2^T, modulo "
                    "quarter turns."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

// Everything the layer is made with.
struct OrientationOptions {
  SegmentOptions segments;
  GreatCircleOptions circles;
  ManhattanOptions manhattan;
  BearingFeatureOptions bearings;
  FollowOptions follow;
  TraversabilityOptions traversability;
  int step = 10;
  int motion_frames = 5;
  TurnOptions turns;
  CorridorOptions corridors;
  OrientationLoopOptions loops;
  int image_width = 320;

  static constexpr auto Fields(const auto& use) {
    return use(
        OptionGroup{"segments", &OrientationOptions::segments},
        OptionGroup{"circles", &OrientationOptions::circles},
        OptionGroup{"manhattan", &OrientationOptions::manhattan},
        OptionGroup{"bearings", &OrientationOptions::bearings},
        OptionGroup{"follow", &OrientationOptions::follow},
        OptionGroup{"traversability", &OrientationOptions::traversability},
        OptionField{"step", &OrientationOptions::step, Closed(1, 1000), "frames",
                    "The paper's n: number of frames from one traversability test to the next. "
                    "Higher values take less time, but place nodes less precisely."},
        OptionField{"motion_frames", &OrientationOptions::motion_frames, Closed(1, 100), "frames",
                    "Number of frames over which the direction of motion is measured. Higher "
                    "values measure slow motion better, but cut corners."},
        OptionGroup{"turns", &OrientationOptions::turns},
        OptionGroup{"corridors", &OrientationOptions::corridors},
        OptionGroup{"loops", &OrientationOptions::loops},
        OptionField{"image_width", &OrientationOptions::image_width, Closed(0, 4096), "px",
                    "Width of the thumbnail stored for each node; 0 stores none."});
  }
  void Check() const;  // throws MapError(kBadOptions)
};

}  // namespace waystone
