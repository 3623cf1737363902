// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/posed_queries.h"

#include <Eigen/Dense>
#include <cstdio>
#include <utility>

#include "bench/accuracy/common.h"
#include "core/geometry/angle.h"
#include "core/geometry/rotation.h"

namespace waystone::bench {
namespace {

using Eigen::Isometry3d;

double ComputeNees(const QueryPose& pose, const Isometry3d& truth) {
  Eigen::Matrix<double, 6, 1> error;
  error.head<3>() = truth.translation() - pose.frame_from_camera.translation();
  const Eigen::AngleAxisd turn(truth.linear() * pose.frame_from_camera.linear().transpose());
  error.tail<3>() = turn.angle() * turn.axis();
  return error.dot(pose.covariance.ldlt().solve(error)) / 6;
}

void PrintErrors(const char* of, const std::optional<NodePoseErrors>& errors, int measured) {
  if (!errors) {
    std::printf("%s: errors not measured (%d answers)\n", of, measured);
    return;
  }
  std::printf("%s: position x %.2f, height %.3f, heading %.2f deg, tilt %.2f deg on %d answers\n",
              of, errors->position_factor, errors->height_sigma,
              errors->heading_sigma_rad * kDegreesPerRadian,
              errors->tilt_sigma_rad * kDegreesPerRadian, measured);
}

void PrintNodes(const BuildResult& built) {
  const NodePoseReport& report = built.report.node_poses.value();
  std::printf("map: %d of %d panoramas posed, %.1f %% of motions consistent, %.1f s\n",
              report.posed, report.nodes, 100 * report.consistent.value_or(-0.01),
              built.report.total_s);
  PrintErrors("by appearance", built.map.poses->appearance_errors, report.measured_by_appearance);
  PrintErrors("by features", built.map.poses->verified_errors, report.measured_by_features);
}

void PrintStructure(const BuildResult& built) {
  const PoseReport& report = built.report.poses.value();
  std::printf(
      "map: %d of %d keyframes posed, %d planes fitted of %zu, %d of %d features placed, "
      "%d contradict, %.1f %% of matches consistent, %.2f s of %.1f s\n"
      "pose noise %.4f, %.3f deg by %d of %d keyframes\n",
      report.posed, report.keyframes, report.planes, built.map.planes.size(), report.placed,
      report.features, report.contradicting, 100 * report.consistent, report.seconds,
      built.report.total_s, report.noise.noise.position_sigma,
      report.noise.noise.rotation_sigma_rad * kDegreesPerRadian, report.noise.measured,
      report.noise.asked);
}

}  // namespace

void AskPose(const MapIndex& index, const cv::Mat& grey, const std::optional<Camera>& camera,
             const Isometry3d& truth, const std::string& name, PoseErrors& errors) {
  LocalizeOptions options;
  options.camera = camera;
  const Answer answer = LocalizeImage(index, grey, options);
  ++errors.asked;
  errors.localized += answer.verdict == Verdict::kLocalized;
  if (!answer.pose) {
    std::printf("%s: %s %s\n", name.c_str(), NameOf(answer.verdict), answer.pose_reason.c_str());
    return;
  }
  const Isometry3d& pose = answer.pose->frame_from_camera;
  errors.metres.push_back((pose.translation() - truth.translation()).norm());
  errors.degrees.push_back(RotationAngle(pose.linear(), truth.linear()) * kDegreesPerRadian);
  errors.nees.push_back(ComputeNees(*answer.pose, truth));
  errors.ms.push_back(answer.timing.pose_ms);
  errors.inliers.push_back(answer.pose->inliers);
  std::printf("%s: %.4f m %.3f deg, nees/6 %.2f, %d inliers, %.2f ms\n", name.c_str(),
              errors.metres.back(), errors.degrees.back(), errors.nees.back(), answer.pose->inliers,
              errors.ms.back());
}

nlohmann::ordered_json SummarisePoses(const std::string& name, const PoseErrors& errors) {
  const auto within = [&](double metres, double degrees) {
    int count = 0;
    for (size_t i = 0; i < errors.metres.size(); ++i) {
      count += errors.metres[i] <= metres && errors.degrees[i] <= degrees;
    }
    return count;
  };
  double mean_nees = 0;
  for (const double nees : errors.nees) mean_nees += nees / static_cast<double>(errors.nees.size());
  return {{"set", name},
          {"asked", errors.asked},
          {"localized", errors.localized},
          {"posed", errors.metres.size()},
          {"median_cm", 100 * Quantile(errors.metres, 0.5)},
          {"median_deg", Quantile(errors.degrees, 0.5)},
          {"p90_cm", 100 * Quantile(errors.metres, 0.9)},
          {"p90_deg", Quantile(errors.degrees, 0.9)},
          {"within_5cm_2deg", within(0.05, 2)},
          {"within_10cm_0.5deg", within(0.1, 0.5)},
          {"within_15cm_5deg", within(0.15, 5)},
          {"within_25cm_2deg", within(0.25, 2)},
          {"within_50cm_5deg", within(0.5, 5)},
          {"within_5m_10deg", within(5, 10)},
          {"median_nees", Quantile(errors.nees, 0.5)},
          {"mean_nees", mean_nees},
          {"median_inliers", Quantile(errors.inliers, 0.5)},
          {"median_pose_ms", Quantile(errors.ms, 0.5)},
          {"p90_pose_ms", Quantile(errors.ms, 0.9)}};
}

GivenPoses PosesByFrame(std::function<std::optional<Isometry3d>(int)> of_frame) {
  return {.frame = "truth",
          .unit = LengthUnit::kMetres,
          .of_image = [of_frame = std::move(of_frame)](const Sequence&, const FrameInfo& image) {
            return of_frame(image.number);
          }};
}

BuildResult BuildPosed(std::unique_ptr<Source> source, const std::optional<GivenPoses>& poses,
                       BuildOptions options) {
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::move(source));
  options.images = false;
  BuildResult built = BuildMap(sources, options, {}, poses);
  if (built.report.poses) PrintStructure(built);
  if (built.report.node_poses) PrintNodes(built);
  return built;
}

}  // namespace waystone::bench
