// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <opencv2/core.hpp>

#include "world/render.h"
#include "world/walk.h"
#include "world/world.h"

// Rendered buildings whose storeys share the plan, doors and some of the posters, and photos of
// them.
namespace waystone::bench {

// How a building looks, which varies with its seed: how bare its walls are, how rich their looks,
// how large its posters are, how many of them show one picture, and how many hang on every storey.
WorldOptions DrawBuilding(int building);

// Every second building has the demo plan, the others have the other plan.
FloorPlan PlanOf(int building);

// The storey of that number, from 0.
World StoreyOf(int building, int storey);

// Of maps and queries, `width` pixels wide and three quarters as high.
Camera LookAlikeCamera(int width);

// Images of the storey, kTourFrames of them. Visits differ in how unsteady the hand is.
constexpr int kTourFrames = 48;
Walk MapTour(const World& world, int visit = 1);

// 30 images of another visit, which varies with `seed`: another height and gaze, up to 0.8 m aside
// and turned by up to 0.6 rad.
Walk QueryTour(const World& world, int seed);

// A photo, CV_8UC1, with another camera's blur, noise and exposure, and for about half of the seeds
// another light.
cv::Mat Photograph(const Renderer& renderer, const World& world,
                   const Eigen::Isometry3d& world_from_camera, uint64_t seed);

}  // namespace waystone::bench
