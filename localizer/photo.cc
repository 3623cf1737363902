// SPDX-License-Identifier: Apache-2.0
#include "localizer/photo.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/base/check.h"
#include "core/camera/rig.h"
#include "localizer/appearance.h"

namespace waystone {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kPoses = 10;        // nodes whose relative pose is looked for
constexpr size_t kWitnesses = 2;  // nodes that have to agree

double MillisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// Why a photo can't be asked for, if so.
std::string Hindrance(const MapIndex& index, const cv::Mat& grey,
                      const std::optional<Camera>& camera) {
  if (!camera) {
    return "this map knows panoramas alone, and the image isn't twice as wide as high; send a "
           "panorama, or say the photo's field of view";
  }
  if (grey.cols != camera->width || grey.rows != camera->height) {
    return "the camera takes " + std::to_string(camera->width) + "x" +
           std::to_string(camera->height) + " pixels, the photo has " + std::to_string(grey.cols) +
           "x" + std::to_string(grey.rows) + "; send it unscaled, or say its field of view";
  }
  const auto keeps = [](const AppearanceNode& node) { return !node.features.bearings.empty(); };
  if (!std::ranges::any_of(index.map().appearance->nodes, keeps)) {
    return "the map's panoramas keep no features, without which a photo can't be found among them; "
           "send a panorama, or build the map with --node-features";
  }
  return "";
}

BearingFeatures RaysOf(const cv::Mat& grey, const Camera& camera, FeatureType type,
                       const PanoramaQueryOptions& options) {
  BearingFeatureOptions bearings = options.features.bearings;
  bearings.features.type = type;
  bearings.features.max_features = bearings.max_kept = options.photo_features;
  return ExtractBearings(RigOfOne(camera), std::vector<cv::Mat>{grey}, bearings);
}

// All nodes that may be asked, without any order yet: a photo has no signature to rank them by.
std::vector<ComparedNode> NodesToAsk(const MapIndex& index, const std::vector<bool>& left_out) {
  std::vector<ComparedNode> nodes;
  for (int node = 0; node < std::ssize(index.map().appearance->nodes); ++node) {
    if (!left_out.empty() && left_out[node]) continue;
    ComparedNode compared;
    compared.node = node;
    compared.cost = 1;
    nodes.push_back(compared);
  }
  return nodes;
}

// The nodes whose headings of the photo agree, by the most inliers together, best first. A photo
// that sees a single wall fits two motions to each node; two nodes seldom agree in the wrong ones.
std::vector<ComparedNode> Agreeing(const std::vector<ComparedNode>& nodes) {
  constexpr double kAgree_rad = 0.06;
  std::vector<ComparedNode> best;
  int most = 0;
  for (const ComparedNode& one : nodes) {
    std::vector<ComparedNode> agreeing;
    int inliers = 0;
    for (const ComparedNode& other : nodes) {
      if (other.inliers == 0) continue;
      if (std::abs(WrappedAngle(other.heading_rad - one.heading_rad)) > kAgree_rad) continue;
      agreeing.push_back(other);
      inliers += other.inliers;
    }
    if (one.inliers == 0 || inliers <= most) continue;
    most = inliers;
    best = std::move(agreeing);
  }
  return best;
}

}  // namespace

Answer LocalizePhoto(const MapIndex& index, const cv::Mat& grey,
                     const std::optional<Camera>& camera, const PanoramaQueryOptions& options,
                     const std::vector<bool>& left_out) {
  options.Check();
  WS_CHECK(index.HasAppearance(), "the map has no appearance layer");
  const auto start = Clock::now();
  Answer answer;
  answer.map = index.map().info.name;
  answer.map_version = index.map().info.version;
  answer.decided_by = "photo";
  answer.message = Hindrance(index, grey, camera);
  if (!answer.message.empty()) return answer;
  const BearingFeatures query = RaysOf(grey, *camera, index.map().info.feature_type, options);
  const double extract_ms = MillisecondsSince(start);
  PanoramaQueryOptions asked = options;
  asked.max_poses = std::max(options.max_poses, kPoses);
  const std::vector<ComparedNode> nodes =
      Agreeing(VerifyByFeatures(index, query, NodesToAsk(index, left_out), asked));
  if (nodes.size() < kWitnesses) {
    answer.message =
        "no two panoramas of the map show enough of this photo; step back, or send a panorama";
  } else {
    PanoramaQueryOptions rays_alone = options;
    rays_alone.fine_heading = false;  // a photo has no signature
    answer = AnswerFor(index, {}, nodes, true, rays_alone);
    answer.decided_by = "photo_features";
  }
  answer.timing.total_ms = MillisecondsSince(start);
  answer.timing.extract_ms = extract_ms;
  answer.timing.verify_ms = answer.timing.total_ms - extract_ms;
  return answer;
}

}  // namespace waystone
