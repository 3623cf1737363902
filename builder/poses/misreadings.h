// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <string>

namespace waystone {

// Another way to read given poses.
using PoseReading = std::function<Eigen::Isometry3d(const Eigen::Isometry3d&)>;

// What to do about poses that contradict the images: the readings in which poses are often mistaken
// that make a share of at least `least` of what is compared agree, `share_of` giving this share;
// else what to check. Turns alone can't tell a mirrored frame from a camera's other axes.
std::string RemedyFor(const std::function<double(const PoseReading&)>& share_of, double least);

// "37%".
std::string SharePercent(double share);

}  // namespace waystone
