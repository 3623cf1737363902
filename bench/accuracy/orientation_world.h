// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "core/camera/rig.h"
#include "world/render.h"
#include "world/walk.h"
#include "world/world.h"

namespace waystone::bench {

// A bend of the trajectory by a right angle.
struct TrueTurn {
  int frame = 0;      // nearest to the corner
  int direction = 1;  // 1 left, -1 right
};

// Frames, both included.
struct TrueStretch {
  int first = 0;
  int last = 0;
};

// A drive through a made building: a corridor that runs around in a loop, and a room on the way.
struct OrientationWorld {
  std::string name;
  std::shared_ptr<const World> world;
  Walk walk;
  std::vector<TrueTurn> turns;
  std::vector<TrueStretch> corridors;  // where the view ahead is along a straight corridor
  TrueStretch looked_aside;            // the camera turns while it moves straight on
  TrueStretch skewed;                  // within the part of a corridor with slanted stripes
  Eigen::Vector2d skew_low;            // that part on the ground, m
  Eigen::Vector2d skew_high;
};

// One of three buildings, 0 to 2, driven through in about `frames` frames. The camera looks along
// the trajectory but for one stretch in which it turns by 70 degrees and back. One part of a
// corridor has stripes painted on floor, ceiling and walls that run along none of the building's
// axes. Without `trim` (see WorldOptions) surfaces are full of shapes at any angle, and nearly all
// lines are theirs.
OrientationWorld MakeOrientationWorld(int building, int frames, bool trim);

// The pictures of a frame, one per camera, as JPEG files.
std::vector<std::vector<unsigned char>> RenderRig(const OrientationWorld& made, const Rig& rig,
                                                  const std::vector<Renderer>& renderers,
                                                  int frame);

// The share of what a rig sees in frame `a` (rays drawn over the rig's images) that it also sees in
// frame `b`: in some camera, not hidden, at a distance of at most `max_scale` times as far or as
// near.
double CommonView(const OrientationWorld& made, const Rig& rig, int a, int b, double max_scale);

}  // namespace waystone::bench
