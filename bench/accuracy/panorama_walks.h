// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "core/geometry/pose2.h"
#include "core/panorama/fourier_signature.h"
#include "core/trajectory/shape_difference.h"
#include "world/walk.h"
#include "world/world.h"

namespace waystone::bench {

// A rendered drive with panoramas.
struct PanoramaWalk {
  std::string name;
  World world;
  Walk walk;
};

inline constexpr int kPanoramaWidth = 512;  // px

// The paper's two settings ("office", "laboratory") and, in another building, two by which nothing
// was ever chosen: "tour", driven like those, and "uneven", by a hand that sways, with a gaze that
// swings and steps of 10 to 30 cm. Throws MapError(kBadOptions) for another name.
PanoramaWalk PanoramaWalkByName(const std::string& name);
std::vector<std::string> PanoramaWalkNames();

// The signatures of all its panoramas, with default options.
std::vector<FourierSignature> DescribeWalk(const PanoramaWalk& walk);

// The places of poses.
Points2 PlacesOf(const std::vector<Pose2>& poses);

}  // namespace waystone::bench
