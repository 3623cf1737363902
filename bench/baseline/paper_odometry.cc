// SPDX-License-Identifier: Apache-2.0
#include "bench/baseline/paper_odometry.h"

#include <cmath>

#include "builder/appearance/visual_odometry.h"
#include "core/panorama/visual_compass.h"

namespace waystone::bench {

std::vector<Pose2> FollowByPaper(const std::vector<FourierSignature>& signatures, int k1) {
  PhaseCompassOptions compass;
  compass.power = 0;
  std::vector<Pose2> poses(signatures.empty() ? 0 : 1);
  for (size_t i = 1; i < signatures.size(); ++i) {
    const double turn = TurnByPhases(signatures[i - 1], signatures[i], compass).best.heading_rad;
    const double length = SignatureDistance(signatures[i - 1], signatures[i], k1);
    poses.push_back(poses.back() * Pose2{length * std::cos(turn), length * std::sin(turn), turn});
  }
  return poses;
}

}  // namespace waystone::bench
