// SPDX-License-Identifier: Apache-2.0
#include "bench/baseline/scenes.h"

#include "core/base/check.h"
#include "core/homography/homography.h"

namespace waystone::bench {

std::vector<Eigen::Vector2d> MoveAll(const Eigen::Matrix3d& b_from_a,
                                     const std::vector<Eigen::Vector2d>& points) {
  std::vector<Eigen::Vector2d> moved;
  for (const Eigen::Vector2d& x : points) moved.push_back(Apply(b_from_a, x));
  return moved;
}

Eigen::Vector2d InImage(const Eigen::Vector2d& x, int width, int image_width) {
  const double scale = static_cast<double>(image_width) / width;
  return ((x.array() + 0.5) * scale - 0.5).matrix();
}

SceneAnswer SceneAnswerOf(const MapIndex& index, const Answer& answer) {
  WS_CHECK(answer.verdict == Verdict::kLocalized, "only a localized answer names a place");
  const int image = index.FindKeyframe(answer.planes.keyframe->id)->frame;
  if (answer.planes.recognised.empty()) {
    const EpipolarMatches& matches = answer.planes.epipolar.value();
    const Keyframe& keyframe = *index.FindKeyframe(matches.keyframe.id);
    return {image, keyframe.frame, matches.query_points, matches.keyframe_points, keyframe.width};
  }
  const RecognisedPlane& best = answer.planes.recognised.front();
  const Keyframe& reference = *index.FindKeyframe(best.reference.id);
  return {image, reference.frame, best.query_points,
          MoveAll(best.reference_from_query, best.query_points), reference.width};
}

}  // namespace waystone::bench
