// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/features/features.h"

// How points are spread over an image: many in one spot say little about where it was taken.
namespace waystone {

// Whether features at x (px) can be expected to be found in an image: it isn't clipped there, and
// the border is well away.
bool CanShow(const Features& image, const Eigen::Vector2d& x);

// Points of which none is nearer than `apart` to one counted before; both in px.
int CountApart(const std::vector<Eigen::Vector2d>& points, double apart);

// Share of the cells of a width x height image, five along each side, that have a point, in [0, 1].
// The points lie inside.
double ComputeCoverage(const std::vector<Eigen::Vector2d>& points, int width, int height);

}  // namespace waystone
