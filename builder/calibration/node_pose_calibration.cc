// SPDX-License-Identifier: Apache-2.0
#include "builder/calibration/node_pose_calibration.h"

#include <tbb/parallel_for.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "builder/calibration/map_parts.h"
#include "core/robust/quantile.h"
#include "localizer/appearance/appearance.h"
#include "localizer/poses/node_pose.h"

namespace waystone {
namespace {

constexpr int kFewestAnswers = 8;
// The share of errors within one standard deviation of a normal distribution, and the quantile of
// chi-squared with two degrees of freedom for the same share (with one it is 1). Position errors
// have long tails: calibrated by their median, answers appeared twice as sure.
constexpr double kWithinOneSigma = 0.683;
constexpr double kChi2By2 = 2.297;
// Lower bounds, so that covariances can be inverted: where all cameras are at one height, errors of
// heights are 0. Shares of the spacing, and rad.
constexpr double kLeastHeightSpacings = 1e-3;
constexpr double kLeastTilt_rad = 1e-3;
constexpr double kLeastFactor = 0.1;

// How far an answer is from the given pose: squares.
struct NodeError {
  double on_ground2 = 0;  // over the answer's own variance; two degrees of freedom
  double height2 = 0;
  double heading2 = 0;
  double heading_variance = 0;  // the answer's own
  double tilt2 = 0;             // two degrees of freedom
};

NodeError CompareWithGiven(const Horizontal& horizontal, const QueryPose& pose,
                           const NodePose& given) {
  Eigen::Matrix<double, 3, 2> level;
  level << horizontal.right, horizontal.top;
  const Eigen::Vector3d off = pose.frame_from_camera.translation() - given.position;
  const Eigen::Vector2d on_ground = level.transpose() * off;
  const Eigen::Matrix2d covariance =
      level.transpose() * pose.covariance.topLeftCorner<3, 3>() * level;
  const Eigen::AngleAxisd turn(pose.frame_from_camera.linear() *
                               given.rotation.toRotationMatrix().transpose());
  const Eigen::Vector3d turned = turn.angle() * turn.axis();
  const double heading = horizontal.up.dot(turned);
  NodeError error;
  error.on_ground2 = on_ground.dot(covariance.ldlt().solve(on_ground));
  error.height2 = std::pow(horizontal.up.dot(off), 2);
  error.heading2 = heading * heading;
  error.heading_variance =
      horizontal.up.dot(pose.covariance.bottomRightCorner<3, 3>() * horizontal.up);
  error.tilt2 = (level.transpose() * turned).squaredNorm();
  return error;
}

std::optional<NodeError> AskWithoutItself(const MapIndex& index,
                                          const AppearanceSampleFrame& sample, bool verified,
                                          const PanoramaQueryOptions& options) {
  const std::vector<AppearanceNode>& nodes = index.map().appearance->nodes;
  const NodePose* given = index.map().poses->Find(nodes[sample.node].id);
  if (!given) return std::nullopt;
  PanoramaQuery query{sample.signature, std::nullopt};
  if (verified) query.features = sample.features;
  std::vector<bool> left_out(nodes.size(), false);
  left_out[sample.node] = true;
  const Answer answer = LocatePanorama(index, query, options, left_out);
  if (answer.verdict != Verdict::kLocalized || IsVerified(*answer.panorama) != verified) {
    return std::nullopt;
  }
  const auto pose = EstimateNodePose(index, answer, {});
  if (!pose) return std::nullopt;
  // Wrong places are covered by the answer's probability.
  const double apart = (pose->frame_from_camera.translation() - given->position).norm();
  if (apart > options.elsewhere_spacings * index.appearance().spacing()) return std::nullopt;
  return CompareWithGiven(*index.horizontal(), *pose, *given);
}

double OneSigmaOf(const std::vector<NodeError>& all, double NodeError::*square) {
  std::vector<double> squares;
  for (const NodeError& one : all) squares.push_back(one.*square);
  return Quantile(std::move(squares), kWithinOneSigma);
}

// The additional standard deviation with which, together with the answers' own, that share of the
// headings is within one sigma.
double ExtraHeadingSigma(const std::vector<NodeError>& all) {
  std::vector<double> beyond;
  for (const NodeError& one : all) beyond.push_back(one.heading2 - one.heading_variance);
  return std::sqrt(std::max(0.0, Quantile(std::move(beyond), kWithinOneSigma)));
}

// Nothing where there are too few answers.
std::optional<NodePoseErrors> MeasureErrors(const MapIndex& index,
                                            const std::vector<AppearanceSampleFrame>& samples,
                                            bool verified, const PanoramaQueryOptions& options,
                                            int& measured) {
  std::vector<std::optional<NodeError>> found(samples.size());
  tbb::parallel_for(size_t{0}, samples.size(), [&](size_t i) {
    const bool asked = samples[i].node >= 0 && (!verified || samples[i].features.size() > 0);
    if (asked) found[i] = AskWithoutItself(index, samples[i], verified, options);
  });
  std::vector<NodeError> all;
  for (const auto& one : found) {
    if (one) all.push_back(*one);
  }
  measured = static_cast<int>(all.size());
  if (measured < kFewestAnswers) return std::nullopt;
  const double spacing = index.appearance().spacing();
  const auto sigma = [&all](double NodeError::*square, double chi2) {
    return std::sqrt(OneSigmaOf(all, square) / chi2);
  };
  return NodePoseErrors{
      .position_factor = std::max(kLeastFactor, sigma(&NodeError::on_ground2, kChi2By2)),
      .height_sigma = std::max(kLeastHeightSpacings * spacing, sigma(&NodeError::height2, 1)),
      .heading_sigma_rad = ExtraHeadingSigma(all),
      .tilt_sigma_rad = std::max(kLeastTilt_rad, sigma(&NodeError::tilt2, kChi2By2))};
}

}  // namespace

void MeasureNodePoseErrors(const std::vector<AppearanceSampleFrame>& samples,
                           const PanoramaQueryOptions& options, MapData& map,
                           NodePoseReport& report) {
  const auto index = MapIndex::Build(CopyPanoramas(map));
  map.poses->appearance_errors =
      MeasureErrors(*index, samples, false, options, report.measured_by_appearance);
  map.poses->verified_errors =
      MeasureErrors(*index, samples, true, options, report.measured_by_features);
}

}  // namespace waystone
