// SPDX-License-Identifier: Apache-2.0
#include "builder/calibration/pose_calibration.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>

#include "builder/calibration/map_parts.h"
#include "core/camera/image_plane.h"
#include "core/camera_pose/absolute_pose.h"
#include "core/features/match.h"
#include "localizer/poses/pose_sightings.h"

namespace waystone {
namespace {

using Eigen::Isometry3d;

// How far a keyframe's given pose is from that by the other keyframes, and the expected difference:
// squared lengths, and traces of covariances.
struct Disagreement {
  double position2 = 0;
  double position_variance = 0;
  double rotation2 = 0;
  double rotation_variance = 0;
};

// The features of a keyframe in the map: rows of the index and their descriptors.
struct KeyframeRows {
  std::vector<int> rows;
  Descriptors descriptors;

  void Append(int first, const Descriptors& more) {
    for (int i = 0; i < more.rows(); ++i) {
      rows.push_back(first + i);
      descriptors.Append(more.row(i));
    }
  }
};

// Landmarks, and the planes that are stored with this keyframe: on its rays, by its pose.
KeyframeRows CollectRows(const MapIndex& index, int keyframe, int bytes) {
  KeyframeRows collected{.rows = {}, .descriptors = Descriptors(bytes)};
  collected.Append(index.FirstLandmarkRow(keyframe), index.LandmarkDescriptorsOf(keyframe));
  const KeyframeId id = index.map().keyframes[keyframe].id;
  for (const MapIndex::SeenPlane& seen : index.PlanesSeenBy(keyframe)) {
    if (index.map().planes[seen.plane].reference != id) continue;
    collected.Append(index.FirstRow(seen.plane), index.DescriptorsOf(seen.plane));
  }
  return collected;
}

bool AreNeighbours(const MapIndex& index, int a, int b, int neighbours) {
  const std::vector<Keyframe>& keyframes = index.map().keyframes;
  return keyframes[a].sequence == keyframes[b].sequence && std::abs(a - b) <= neighbours;
}

std::optional<Disagreement> AskOthers(const MapIndex& index, const SampledKeyframe& asked,
                                      int neighbours, const PoseQueryOptions& options) {
  const Features& query = asked.features;
  const int at = index.IndexOf(asked.keyframe);
  const Isometry3d given = index.map().poses->Find(asked.keyframe)->frame_from_camera();
  const Camera camera =
      ScaledCamera(*index.FindSequence(index.map().keyframes[at].sequence)->camera, query.width);
  std::vector<MapMatch> matches;
  const auto is_other = [&](int other) { return !AreNeighbours(index, at, other, neighbours); };
  for (const int other : NearestPosedKeyframes(index, given, options.keyframes, is_other)) {
    const KeyframeRows shown = CollectRows(index, other, query.descriptors.bytes());
    for (const Match& match :
         MatchDescriptors(query.descriptors, shown.descriptors, query.type, {})) {
      matches.push_back({match.a, shown.rows[match.b]});
    }
  }
  const double sigma_rad = options.keypoint_sigma_px * RadiansPerPixel(camera);
  const auto found = FindAbsolutePose(
      MakePointSightings(index, query, camera, sigma_rad, std::move(matches)), options.solve);
  if (!found) return std::nullopt;
  const Isometry3d& pose = found->world_from_camera;
  const Eigen::AngleAxisd turn(given.linear() * pose.linear().transpose());
  return Disagreement{.position2 = (given.translation() - pose.translation()).squaredNorm(),
                      .position_variance = found->covariance.topLeftCorner<3, 3>().trace(),
                      .rotation2 = turn.angle() * turn.angle(),
                      .rotation_variance = found->covariance.bottomRightCorner<3, 3>().trace()};
}

// The standard deviation on each axis, beyond their own, with which half of the errors are within
// the median of chi-squared with three degrees of freedom.
double EstimateSigma(const std::vector<Disagreement>& all, double Disagreement::*error2,
                     double Disagreement::*variance) {
  constexpr double kMedianOfChi2 = 2.366;
  constexpr int kBisections = 40;
  const auto half_within = [&](double sigma) {
    const auto within = std::ranges::count_if(all, [&](const Disagreement& one) {
      return one.*error2 <= kMedianOfChi2 * (one.*variance / 3 + sigma * sigma);
    });
    return 2 * within >= std::ssize(all);
  };
  if (half_within(0)) return 0;
  double low = 0;
  double high = std::sqrt((*std::ranges::max_element(all, {}, error2)).*error2);
  for (int i = 0; i < kBisections; ++i) {
    const double middle = (low + high) / 2;
    (half_within(middle) ? high : low) = middle;
  }
  return high;
}

}  // namespace

PoseNoiseReport MeasurePoseNoise(const MapData& map, const std::vector<SampledKeyframe>& samples,
                                 int neighbours, const PoseQueryOptions& options) {
  std::vector<const SampledKeyframe*> asked;
  for (const SampledKeyframe& sample : samples) {
    if (map.poses->Find(sample.keyframe)) asked.push_back(&sample);
  }
  const auto index = MapIndex::Build(CopyPlanes(map));
  std::vector<std::optional<Disagreement>> found(asked.size());
  tbb::parallel_for(size_t{0}, asked.size(), [&](size_t i) {
    found[i] = AskOthers(*index, *asked[i], neighbours, options);
  });
  std::vector<Disagreement> measured;
  for (const auto& one : found) {
    if (one) measured.push_back(*one);
  }
  PoseNoiseReport report;
  report.asked = static_cast<int>(asked.size());
  report.measured = static_cast<int>(measured.size());
  if (report.measured < PoseNoiseReport::kFewest) return report;
  report.noise.position_sigma =
      EstimateSigma(measured, &Disagreement::position2, &Disagreement::position_variance);
  report.noise.rotation_sigma_rad =
      EstimateSigma(measured, &Disagreement::rotation2, &Disagreement::rotation_variance);
  return report;
}

}  // namespace waystone
