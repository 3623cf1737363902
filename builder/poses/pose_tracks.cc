// SPDX-License-Identifier: Apache-2.0
#include "builder/poses/pose_tracks.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <string>
#include <utility>

#include "builder/poses/keyframe_matches.h"
#include "core/base/error.h"
#include "core/camera/image_plane.h"

namespace waystone {
namespace {

PosedView MakeView(const Keyframe& keyframe, const Camera& camera, const Features& features,
                   const Eigen::Isometry3d& pose, double sigma_px) {
  PosedView view{&keyframe, ScaledCamera(camera, features.width), &features, pose, {}, 0};
  view.sigma_rad = sigma_px * RadiansPerPixel(view.camera);
  for (const Keypoint& keypoint : features.keypoints) {
    view.rays.push_back(Unproject(view.camera, PositionOf(keypoint)));
  }
  return view;
}

const Camera& CameraOf(const Sequence& sequence) {
  if (sequence.camera) return *sequence.camera;
  throw MapError(ErrorCode::kBadCamera, "poses were given, but the sequence '" + sequence.name +
                                            "' has no calibration; specify it with --camera");
}

void RequirePoses(const MapData& map, const std::vector<PosedView>& views, const Keyframe* first,
                  double min_posed) {
  const auto keyframes = std::ssize(map.keyframes);
  if (!views.empty() && std::ssize(views) >= min_posed * static_cast<double>(keyframes)) return;
  throw MapError(ErrorCode::kBadRequest,
                 "only " + std::to_string(views.size()) + " of " + std::to_string(keyframes) +
                     " keyframes have a pose (first without: " + first->source +
                     "); check that the poses are of these images, by name or time");
}

}  // namespace

std::vector<PosedView> CollectPosedViews(const MapData& map,
                                         const std::vector<SampledKeyframe>& features,
                                         const GivenPoses& poses, const PoseOptions& options) {
  std::vector<PosedView> views;
  const Keyframe* first_without = nullptr;
  for (const Keyframe& keyframe : map.keyframes) {
    const Sequence& sequence =
        *std::ranges::lower_bound(map.sequences, keyframe.sequence, {}, &Sequence::id);
    const Camera& camera = CameraOf(sequence);
    const auto pose = poses.of_image(sequence, {keyframe.frame, keyframe.source, keyframe.time_s});
    const auto found =
        std::ranges::lower_bound(features, keyframe.id, {}, &SampledKeyframe::keyframe);
    if (pose && found != features.end() && found->keyframe == keyframe.id) {
      views.push_back(
          MakeView(keyframe, camera, found->features, *pose, options.keypoint_sigma_px));
    } else if (!first_without) {
      first_without = &keyframe;
    }
  }
  RequirePoses(map, views, first_without, options.min_posed);
  return views;
}

PoseTracks::PoseTracks(const std::vector<PosedView>& views, const PoseOptions& options)
    : views_(views), options_(options) {
  for (int a = 0; a < std::ssize(views); ++a) {
    for (int b = a + 1; b < std::ssize(views) && b <= a + options.neighbours; ++b) {
      const bool together = views[a].keyframe->sequence == views[b].keyframe->sequence &&
                            views[a].keyframe->stretch == views[b].keyframe->stretch;
      if (together) pairs_.push_back({a, b, {}});
    }
  }
  tbb::parallel_for(size_t{0}, pairs_.size(), [&](size_t p) {
    const Features& a = *views_[pairs_[p].a].features;
    const Features& b = *views_[pairs_[p].b].features;
    if (auto matches = MatchImages(a, b, options_.match, options_.epipolar)) {
      pairs_[p].features = std::move(matches->features);
    }
  });
  Link(pairs_);
}

void PoseTracks::Link(const std::vector<LinkedPair>& pairs) {
  for (const PosedView& view : views_) links_.emplace_back(view.features->size());
  for (const LinkedPair& pair : pairs) {
    for (const auto& [a, b] : pair.features) {
      links_[pair.a][a].push_back({pair.b, b});
      links_[pair.b][b].push_back({pair.a, a});
    }
  }
}

double PoseTracks::ConsistentShare(const std::vector<Eigen::Isometry3d>& poses,
                                   double max_sigmas) const {
  DepthOptions options = options_.depth;
  options.max_sigmas = max_sigmas;
  options.min_sightings = 1;
  std::vector<std::pair<int64_t, int64_t>> counts(pairs_.size());
  tbb::parallel_for(size_t{0}, pairs_.size(), [&](size_t p) {
    const LinkedPair& pair = pairs_[p];
    const Eigen::Isometry3d b_from_a = poses[pair.b].inverse() * poses[pair.a];
    for (const auto& [a, b] : pair.features) {
      const RaySighting sighting{b_from_a, views_[pair.b].rays[b], views_[pair.b].sigma_rad};
      const DepthEstimate depth = EstimateDepth(views_[pair.a].rays[a], {&sighting, 1}, options);
      counts[p].first += depth.error != DepthError::kContradiction;
      ++counts[p].second;
    }
  });
  int64_t consistent = 0;
  int64_t all = 0;
  for (const auto& [right, of] : counts) {
    consistent += right;
    all += of;
  }
  return all == 0 ? 1 : static_cast<double>(consistent) / static_cast<double>(all);
}

}  // namespace waystone
