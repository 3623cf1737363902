// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/geometry/angle.h"
#include "core/geometry/pose2.h"
#include "core/panorama/visual_compass.h"
#include "world/flat.h"

// The compass in small rooms: furniture within reach, white walls, windows that blind, lamps that
// are on or off between the visits.
namespace waystone {
namespace {

constexpr double kNear_m = 1.5;
constexpr double kRight_rad = 10 * kDegree;
constexpr double kClaim_rad = 5 * kDegree;

double YawOf(const FlatPanorama& panorama) {
  const Eigen::Vector3d gaze = panorama.world_from_camera.linear().col(2);
  return std::atan2(gaze.y(), gaze.x());
}

struct Tally {
  int pairs = 0;
  int right = 0;
  int claims = 0;
  int right_claims = 0;
};

void AskPairs(uint64_t seed, Tally& tally) {
  FlatOptions options;
  options.seed = seed;
  const Flat flat = MakeFlat(options);
  FlatTourOptions tour;
  tour.seed = seed;
  tour.per_room = 4;
  tour.camera.width_px = 256;
  const std::vector<FlatPanorama> panoramas = PhotographFlat(flat, tour);
  std::vector<FourierSignature> signatures;
  for (const FlatPanorama& panorama : panoramas) signatures.push_back(Signature(panorama.grey));
  for (size_t a = 0; a < panoramas.size(); ++a) {
    for (size_t b = a + 1; b < panoramas.size(); ++b) {
      const Eigen::Vector3d& from = panoramas[a].place.at;
      const Eigen::Vector3d& to = panoramas[b].place.at;
      if ((to - from).head<2>().norm() >= kNear_m || !SeesThrough(flat.scene, from, to)) continue;
      const CompassHeading heading = RelativeHeading(signatures[a], signatures[b]);
      const double truth = YawOf(panoramas[b]) - YawOf(panoramas[a]);
      const bool right = std::abs(WrappedAngle(heading.heading_rad - truth)) < kRight_rad;
      const bool claims = heading.sigma_rad <= kClaim_rad;
      ++tally.pairs;
      tally.right += right;
      tally.claims += claims;
      tally.right_claims += right && claims;
    }
  }
}

// 4 flats with about 60 pairs each. Columns matched one way, by level edges alone, had 35 % right
// of these pairs.
TEST(CompassFlatsTest, FindsHeadingsInSmallRooms) {
  Tally tally;
  for (const uint64_t seed : {11, 12, 13, 14}) AskPairs(seed, tally);
  RecordProperty("pairs", tally.pairs);
  RecordProperty("right", tally.right);
  RecordProperty("claims", tally.claims);
  ASSERT_GT(tally.pairs, 200);
  EXPECT_GT(tally.right, 0.55 * tally.pairs) << tally.right << " of " << tally.pairs;
  EXPECT_GE(tally.right_claims, 0.95 * tally.claims)
      << tally.right_claims << " of " << tally.claims;
  EXPECT_GT(tally.claims, 0.05 * tally.pairs) << "a compass that hardly claims anything";
}

}  // namespace
}  // namespace waystone
