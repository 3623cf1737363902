// SPDX-License-Identifier: Apache-2.0
#include "builder/poses/add_poses.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "builder/poses/misreadings.h"
#include "builder/poses/pose_tracks.h"
#include "builder/poses/structure.h"
#include "core/base/clock.h"
#include "core/base/error.h"

namespace waystone {
namespace {

using Eigen::Isometry3d;

std::vector<Isometry3d> PosesOf(const std::vector<PosedView>& views) {
  std::vector<Isometry3d> poses;
  for (const PosedView& view : views) poses.push_back(view.frame_from_camera);
  return poses;
}

double RequireConsistency(const std::vector<PosedView>& views, const PoseTracks& tracks,
                          const PoseOptions& options) {
  const std::vector<Isometry3d> poses = PosesOf(views);
  const double max_sigmas = options.depth.max_sigmas;
  const double share = tracks.ConsistentShare(poses, max_sigmas);
  if (share >= options.min_consistent) return share;
  const auto share_of = [&](const PoseReading& read) {
    std::vector<Isometry3d> corrected;
    for (const Isometry3d& pose : poses) corrected.push_back(read(pose));
    return tracks.ConsistentShare(corrected, max_sigmas);
  };
  throw MapError(ErrorCode::kBadRequest,
                 "the poses contradict the images: only " + SharePercent(share) +
                     " of the matches between neighbouring keyframes agree with them; " +
                     RemedyFor(share_of, std::max(options.min_consistent, 2 * share)));
}

// The factor by which the poses' own errors enlarge those of keypoints: that on their sigma at
// which as many matches agree as lie within one sigma of a normal distribution.
double MeasureNoise(const std::vector<PosedView>& views, const PoseTracks& tracks) {
  constexpr double kWithinOneSigma = 0.683;
  constexpr double kLargestNoise = 8;
  constexpr int kBisections = 7;
  const std::vector<Isometry3d> poses = PosesOf(views);
  if (tracks.ConsistentShare(poses, 1) >= kWithinOneSigma) return 1;
  double low = 1;
  double high = kLargestNoise;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = std::sqrt(low * high);
    (tracks.ConsistentShare(poses, middle) >= kWithinOneSigma ? high : low) = middle;
  }
  return high;
}

std::vector<DepthCode> TakeDepths(const std::vector<PlacedFeature>& features, PoseReport& report) {
  std::vector<DepthCode> depths;
  for (const PlacedFeature& feature : features) {
    depths.push_back(feature.depth);
    report.placed += feature.depth.known();
    report.contradicting += feature.contradicts;
  }
  report.features += static_cast<int>(features.size());
  return depths;
}

void AddPlanes(const MapData& map, const StructureEstimator& structure, PoseLayer& layer,
               PoseReport& report) {
  std::vector<PlacedPlane> placed(map.planes.size());
  tbb::parallel_for(size_t{0}, map.planes.size(), [&](size_t p) {
    if (structure.ViewOf(map.planes[p].reference) >= 0) placed[p] = structure.Place(map.planes[p]);
  });
  for (size_t p = 0; p < placed.size(); ++p) {
    const PlaneId id = map.planes[p].id;
    if (placed[p].features.empty()) continue;
    layer.plane_depths.push_back({id, TakeDepths(placed[p].features, report)});
    if (const auto& fit = placed[p].fit) {
      layer.planes.push_back({id, fit->normal, fit->distance, fit->covariance});
    }
  }
  report.planes = static_cast<int>(layer.planes.size());
}

void AddLandmarks(const std::vector<PosedView>& views, const StructureEstimator& structure,
                  PoseLayer& layer, PoseReport& report) {
  std::vector<std::vector<PlacedFeature>> placed(views.size());
  tbb::parallel_for(size_t{0}, views.size(),
                    [&](size_t v) { placed[v] = structure.PlaceLandmarks(*views[v].keyframe); });
  for (size_t v = 0; v < views.size(); ++v) {
    if (placed[v].empty()) continue;
    layer.landmark_depths.push_back({views[v].keyframe->id, TakeDepths(placed[v], report)});
  }
}

}  // namespace

PoseReport AddPoses(const std::vector<SampledKeyframe>& features, const GivenPoses& poses,
                    const PoseOptions& options, MapData& map) {
  const Clock::time_point start = Clock::now();
  std::vector<PosedView> views = CollectPosedViews(map, features, poses, options);
  const PoseTracks tracks(views, options);
  PoseReport report;
  report.keyframes = static_cast<int>(map.keyframes.size());
  report.posed = static_cast<int>(views.size());
  report.consistent = RequireConsistency(views, tracks, options);
  const double noise = MeasureNoise(views, tracks);
  for (PosedView& view : views) view.sigma_rad *= noise;
  PoseLayer layer;
  layer.frame = poses.frame;
  layer.unit = poses.unit;
  for (const PosedView& view : views) {
    layer.keyframes.push_back(MakeKeyframePose(view.keyframe->id, view.frame_from_camera));
  }
  const StructureEstimator structure(map, views, tracks, options, noise);
  AddPlanes(map, structure, layer, report);
  AddLandmarks(views, structure, layer, report);
  map.poses = std::move(layer);
  report.seconds = SecondsSince(start);
  return report;
}

}  // namespace waystone
