// SPDX-License-Identifier: Apache-2.0
#include "builder/joining/align_layers.h"

#include <algorithm>
#include <cmath>

#include "core/robust/median.h"

namespace waystone {
namespace {

constexpr size_t kMaxPoses = 200;  // each pair of which is compared
constexpr size_t kFewestPoses = 3;
constexpr double kMaxTurn_rad = 0.35;
constexpr double kAgreeingSigmas = 3;
constexpr double kBend = 0.25;  // of the distance between two panoramas
// Panoramas nearer to each other than this many of their sigmas say nothing about the scale.
constexpr double kScaleSigmas = 2;

// In the unit of `to`; `scale` of these are one unit of `from`.
double SigmaOf(const PoseInLayers& pose, double scale) {
  return (pose.answered_in_from ? scale : 1) * pose.position_sigma;
}

std::vector<PoseInLayers> EvenlySpread(const std::vector<PoseInLayers>& poses) {
  if (poses.size() <= kMaxPoses) return poses;
  std::vector<PoseInLayers> chosen;
  for (size_t i = 0; i < kMaxPoses; ++i) chosen.push_back(poses[i * poses.size() / kMaxPoses]);
  return chosen;
}

// The median over pairs; nothing where all are at one place.
std::optional<double> FindScale(const std::vector<PoseInLayers>& poses) {
  std::vector<double> scales;
  for (size_t i = 0; i < poses.size(); ++i) {
    for (size_t j = i + 1; j < poses.size(); ++j) {
      const double in_to = Apart(poses[i].in_to, poses[j].in_to);
      const double in_from = Apart(poses[i].in_from, poses[j].in_from);
      if (!(in_from > 0)) continue;
      const double scale = in_to / in_from;
      const double sigma = std::max(SigmaOf(poses[i], scale), SigmaOf(poses[j], scale));
      if (in_to > kScaleSigmas * sigma) scales.push_back(scale);
    }
  }
  if (scales.empty()) return std::nullopt;
  return Median(std::move(scales));
}

LayerChange ChangeBy(const PoseInLayers& pose, double scale) {
  const Pose2 from{scale * pose.in_from.x, scale * pose.in_from.y, pose.in_from.theta_rad};
  return {scale, pose.in_to * Inverse(from)};
}

std::vector<size_t> AgreeingWith(const std::vector<PoseInLayers>& poses, size_t tried,
                                 double scale) {
  const LayerChange change = ChangeBy(poses[tried], scale);
  std::vector<size_t> agreeing;
  for (size_t i = 0; i < poses.size(); ++i) {
    const Pose2 moved = change(poses[i].in_from);
    const double sigma = std::max(SigmaOf(poses[i], scale), SigmaOf(poses[tried], scale));
    const double allowed =
        kAgreeingSigmas * sigma + kBend * Apart(poses[i].in_to, poses[tried].in_to);
    if (Apart(moved, poses[i].in_to) > allowed) continue;
    const double turned = WrappedAngle(moved.theta_rad - poses[i].in_to.theta_rad);
    if (std::abs(turned) <= kMaxTurn_rad) agreeing.push_back(i);
  }
  return agreeing;
}

// The mean rotation, and then the translation that aligns the centroids.
LayerChange Fit(const std::vector<PoseInLayers>& poses, const std::vector<size_t>& agreeing,
                double scale) {
  double sine = 0;
  double cosine = 0;
  for (const size_t i : agreeing) {
    const double turn = poses[i].in_to.theta_rad - poses[i].in_from.theta_rad;
    sine += std::sin(turn);
    cosine += std::cos(turn);
  }
  LayerChange change{scale, {0, 0, std::atan2(sine, cosine)}};
  double x = 0;
  double y = 0;
  for (const size_t i : agreeing) {
    const Pose2 turned = change(poses[i].in_from);
    x += poses[i].in_to.x - turned.x;
    y += poses[i].in_to.y - turned.y;
  }
  change.to_from.x = x / static_cast<double>(agreeing.size());
  change.to_from.y = y / static_cast<double>(agreeing.size());
  return change;
}

}  // namespace

std::optional<LayerChange> AlignLayers(const std::vector<PoseInLayers>& given, bool same_unit) {
  const std::vector<PoseInLayers> poses = EvenlySpread(given);
  if (poses.size() < kFewestPoses) return std::nullopt;
  const std::optional<double> scale = same_unit ? 1.0 : FindScale(poses);
  if (!scale) return std::nullopt;
  std::vector<size_t> best;
  for (size_t i = 0; i < poses.size(); ++i) {
    std::vector<size_t> agreeing = AgreeingWith(poses, i, *scale);
    if (agreeing.size() > best.size()) best = std::move(agreeing);
  }
  if (best.size() < std::max(kFewestPoses, (poses.size() + 1) / 2)) return std::nullopt;
  return Fit(poses, best, *scale);
}

}  // namespace waystone
