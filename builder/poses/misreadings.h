// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <string>

namespace waystone {

// Another interpretation of given poses.
using PoseReading = std::function<Eigen::Isometry3d(const Eigen::Isometry3d&)>;

// Advice on poses that contradict the images: the common misinterpretations under which `share_of`
// (the share of the compared items that agree) is at least `least`, or else what to check.
// Rotations can't distinguish a mirrored frame from other camera axes. Thread-safe if share_of is.
std::string RemedyFor(const std::function<double(const PoseReading&)>& share_of, double least);

// "37%".
std::string SharePercent(double share);

}  // namespace waystone
