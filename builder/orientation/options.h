// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/manhattan/manhattan_frame.h"
#include "core/two_view/bearings.h"
#include "core/two_view/relative_rotation.h"

namespace waystone {

// How axes are followed from frame to frame.
struct FollowOptions {
  // Largest turn between two consecutive frames, 0.01 to 0.7. Where the features say nothing, it
  // bounds how far the axes may have turned. rad
  double max_jump_rad = 0.2;
  // A frame whose best rival has this share of its support at most is believed by itself, 0 to 1.
  // Higher asks the features less often, and believes more frames of single cameras that are wrong.
  double max_clear_rival = 0.6;
  // Frames in a row that have to agree before the axes are settled where none is clear, 1 to 100.
  int min_votes = 5;
  // Largest angle between the axes that the lines give and those that the features' rotation
  // predicts, 0.01 to 0.5. Higher takes the lines of a skewed room for the building's. rad
  double max_drift_rad = 0.09;
  // The same where the lines leave a choice of frames, 0.005 to 0.5. Lower believes fewer frames of
  // single cameras. rad
  double max_rival_drift_rad = 0.04;
  // Standard sigma of a rotation between two frames beside what its matches tell, 1e-5 to 0.1.
  // Higher trusts the lines more and the features less. rad
  double step_sigma_rad = 0.001;
  // A frame is kept every so many to find the quarter turn by, should it get lost, 1 to 1000; and
  // lost ones are compared with those every so many frames, 1 to 100. Fewer cost time.
  int anchor_frames = 20;
  int retry_frames = 5;

  void Check() const;  // throws MapError(kBadOptions)
};

// Whether one frame can be reached in view from another (sec. II-B.2).
struct TraversabilityOptions {
  MatchOptions matching;
  // min_inliers is the paper's 10 correspondences. What a plane leaves open is settled by how the
  // camera turned before, so that near ties alone are left to that.
  RelativeOptions relative{.max_rival = 0.98};
  // Largest angle between the essential matrix's rotation and R1 R2^T, 0.005 to 0.5. Higher
  // connects frames whose rotation is wrong. rad
  double max_disagreement_rad = 0.087;
  // Median angle by which inliers move besides the rotation, from which on the direction of motion
  // is believed, 0.0005 to 0.5. Lower gives a direction to a camera that stands still. rad
  double min_parallax_rad = 0.008;

  void Check() const;
};

// Turns (sec. II-B.1).
struct TurnOptions {
  // How far the heading has to go past half a right angle before the axis is switched, 0 to 0.5.
  // Higher keeps a camera that looks along a diagonal from switching back and forth. rad
  double hysteresis_rad = 0.05;
  // The test joins the frame this many before a jump with the one as many after it, 1 to 100.
  int reach = 5;
  // A motion whose heading is within this angle of an axis follows it, 0.05 to 0.7. Higher settles
  // earlier and takes ways across a room for ways along an axis. rad
  double settled_rad = 0.35;
  // Motions in a row along the same axis before the trajectory counts as following it, 1 to 100.
  // More leave out short detours and short ways between two turns.
  int settled_motions = 3;

  void Check() const;
};

// Corridors (sec. III-C.1).
struct CorridorOptions {
  // Range of the heading within a corridor, 0.05 to 1.5. Higher puts up with more sway. rad
  double heading_range_rad = 0.35;
  // Lines along the corridor over those across it, at least, 1 to 20. Higher leaves out rooms and
  // wide halls.
  double min_ratio = 1.33;
  // Shortest corridor, 1 to 100,000. frames
  int min_frames = 30;
  // Frames in a row that may have no rotation, 0 to 1000.
  int max_gap_frames = 10;

  void Check() const;
};

// Loop closures (sec. III-C.2): stricter than traversability, because places far apart may look
// alike.
struct OrientationLoopOptions {
  // Nodes of one sequence this close are neighbours anyway, 1 to 1,000,000. frames
  int min_gap_frames = 60;
  // Features of a node, the strongest ones, by which earlier nodes are ranked, 10 to 10,000.
  int sample = 600;
  // Best ranked earlier nodes that are verified, 1 to 1000. More find weaker loops and cost time in
  // proportion.
  int candidates = 4;
  // Verified correspondences, 5 to 10,000 (the paper's loop had 46).
  int min_matches = 40;
  // Chance that so many fit by accident, as a power of ten, -300 to 0.
  double max_log10_chance = -20;
  // Largest difference of the two orientations, 0.05 to 3.2. rad
  double max_turn_rad = 0.5;
  // Largest angle between the essential matrix's rotation and R1 R2^T, 0.005 to 0.5. rad
  double max_disagreement_rad = 0.035;

  void Check() const;
};

// Everything the layer is made with.
struct OrientationOptions {
  SegmentOptions segments;
  GreatCircleOptions circles;
  ManhattanOptions manhattan;
  BearingFeatureOptions bearings;
  FollowOptions follow;
  TraversabilityOptions traversability;
  // The paper's n: frames from one test of traversability to the next, 1 to 1000. More cost less
  // time and place nodes less precisely.
  int step = 10;
  // The direction of motion is measured over this many frames, 1 to 100. More frames measure slow
  // motion better and cut corners.
  int motion_frames = 5;
  TurnOptions turns;
  CorridorOptions corridors;
  OrientationLoopOptions loops;
  // Width of the picture kept of each node, 0 (none) to 4096. px
  int image_width = 320;

  void Check() const;  // throws MapError(kBadOptions)
};

}  // namespace waystone
