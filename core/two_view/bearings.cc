// SPDX-License-Identifier: Apache-2.0
#include "core/two_view/bearings.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/camera/image_plane.h"

namespace waystone {
namespace {

// Rows of the features to keep, strongest first: each cell's share, then the strongest of the rest.
std::vector<int> Bucketed(const Features& features, const BearingFeatureOptions& options) {
  const double cell_px =
      static_cast<double>(std::max(features.width, features.height)) / options.buckets;
  const int across = static_cast<int>(std::ceil(features.width / cell_px));
  const int down = static_cast<int>(std::ceil(features.height / cell_px));
  const int share = (options.max_kept + across * down - 1) / (across * down);
  std::vector<int> filled(static_cast<size_t>(across) * down, 0);
  std::vector<int> kept;
  std::vector<int> rest;
  for (int i = 0; i < features.size(); ++i) {  // strongest first
    const Keypoint& at = features.keypoints[i];
    const int x = std::clamp(static_cast<int>(at.x_px / cell_px), 0, across - 1);
    const int y = std::clamp(static_cast<int>(at.y_px / cell_px), 0, down - 1);
    (filled[y * across + x]++ < share ? kept : rest).push_back(i);
  }
  kept.insert(kept.end(), rest.begin(), rest.end());
  kept.resize(std::min(kept.size(), static_cast<size_t>(options.max_kept)));
  return kept;
}

void Append(BearingFeatures& all, const RigCamera& seen, int camera, const Features& features,
            const BearingFeatureOptions& options) {
  const Camera working = ScaledCamera(seen.camera, features.width);
  for (const int i : Bucketed(features, options)) {
    const Keypoint& keypoint = features.keypoints[i];
    const Eigen::Vector3d ray = Unproject(working, PositionOf(keypoint));
    all.rays.emplace_back(seen.rig_from_camera.linear() * ray);
    all.camera.push_back(camera);
    all.keypoints.push_back(keypoint);
    all.descriptors.Append(features.descriptors.row(i));
  }
}

}  // namespace

void BearingFeatureOptions::Check() const { CheckFields("bearings", *this); }

BearingFeatures ExtractBearings(const Rig& rig, std::span<const cv::Mat> images,
                                const BearingFeatureOptions& options) {
  options.Check();
  WS_CHECK(images.size() == rig.cameras.size(), "one image a camera");
  BearingFeatures all;
  all.type = options.features.type;
  all.descriptors = Descriptors(DescriptorBytes(all.type));
  for (size_t i = 0; i < images.size(); ++i) {
    if (images[i].empty()) continue;
    CheckImageSize(rig.cameras[i], images[i].cols, images[i].rows);
    Append(all, rig.cameras[i], static_cast<int>(i), ExtractFeatures(images[i], options.features),
           options);
  }
  return all;
}

MatchedRays MatchBearings(const BearingFeatures& a, const BearingFeatures& b,
                          const MatchOptions& options) {
  MatchedRays rays;
  rays.matches = MatchDescriptors(a.descriptors, b.descriptors, a.type, options);
  for (const Match& match : rays.matches) {
    rays.a.push_back(a.rays[match.a]);
    rays.b.push_back(b.rays[match.b]);
  }
  return rays;
}

}  // namespace waystone
