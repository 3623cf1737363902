// SPDX-License-Identifier: Apache-2.0
#include "localizer/appearance/photo.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/check.h"
#include "core/base/clock.h"
#include "core/camera/rig.h"
#include "localizer/appearance/appearance.h"
#include "localizer/undecided.h"

namespace waystone {
namespace {

constexpr int kPoses = 10;        // nodes whose relative pose is looked for
constexpr size_t kWitnesses = 2;  // nodes that have to agree

// Why a photo can't be asked for, if so.
std::string WhyNotAnswered(const MapIndex& index, const cv::Mat& grey,
                           const std::optional<Camera>& camera) {
  if (!camera) {
    return "this map has panoramas only, and the image is not twice as wide as high; send a "
           "panorama or specify the field of view of the photo";
  }
  if (grey.cols != camera->width || grey.rows != camera->height) {
    return "the camera has " + std::to_string(camera->width) + "x" +
           std::to_string(camera->height) + " pixels, the photo has " + std::to_string(grey.cols) +
           "x" + std::to_string(grey.rows) + "; send it unscaled or specify its field of view";
  }
  const auto keeps = [](const AppearanceNode& node) { return !node.features.bearings.empty(); };
  if (!std::ranges::any_of(index.map().appearance->nodes, keeps)) {
    return "the map stores no panorama features, which are required to localize photos; send a "
           "panorama or build the map with --node-features";
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

// The nodes to match with; a photo has no signature that says more of them.
std::vector<ComparedNode> NodesToAsk(const MapIndex& index, const BearingFeatures& query,
                                     const PanoramaQueryOptions& options,
                                     const std::vector<bool>& left_out) {
  std::vector<ComparedNode> nodes;
  for (const int node :
       index.node_features().MostVoted(query.descriptors, options.photo_candidates,
                                       options.photo_neighbours, options.photo_probes, left_out)) {
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

// The answer by the nodes that agree.
Answer Judged(const MapIndex& index, const std::vector<ComparedNode>& nodes,
              const PanoramaQueryOptions& options) {
  if (nodes.size() >= kWitnesses) {
    PanoramaQueryOptions rays_alone = options;
    rays_alone.fine_heading = false;  // a photo has no signature
    Answer answer = AnswerFor(index, {}, nodes, true, rays_alone);
    answer.decided_by = "photo_features";
    return answer;
  }
  Answer answer;
  answer.decided_by = "photo";
  answer.message = "fewer than two mapped panoramas match this photo; step back or send a panorama";
  return answer;
}

// What comes after the features, with its times.
Answer Ask(const MapIndex& index, const BearingFeatures& query, const LocalizeOptions& options,
           const std::vector<bool>& left_out) {
  if (options.TooLate()) return Undecided("extract");
  const auto start = Clock::now();
  std::vector<ComparedNode> nodes = NodesToAsk(index, query, options.panorama, left_out);
  const double shortlist_ms = MillisecondsSince(start);
  PanoramaQueryOptions asked = options.panorama;
  asked.max_poses = std::max(asked.max_poses, kPoses);
  nodes = Agreeing(VerifyByFeatures(index, query, std::move(nodes), asked, options.deadline));
  Answer answer =
      options.TooLate() ? Undecided("shortlist") : Judged(index, nodes, options.panorama);
  answer.timing.shortlist_ms = shortlist_ms;
  answer.timing.verify_ms = MillisecondsSince(start) - shortlist_ms;
  return answer;
}

}  // namespace

Answer LocalizePhoto(const MapIndex& index, const cv::Mat& grey, const LocalizeOptions& options,
                     const std::vector<bool>& left_out) {
  options.Check();
  WS_CHECK(index.HasAppearance(), "the map has no appearance layer");
  const auto start = Clock::now();
  Answer answer;
  answer.decided_by = "photo";
  answer.message = WhyNotAnswered(index, grey, options.camera);
  if (answer.message.empty()) {
    const BearingFeatures query =
        RaysOf(grey, *options.camera, index.map().info.feature_type, options.panorama);
    const double extract_ms = MillisecondsSince(start);
    answer = Ask(index, query, options, left_out);
    answer.timing.extract_ms = extract_ms;
  }
  answer.map = index.map().info.name;
  answer.map_version = index.map().info.version;
  answer.timing.total_ms = MillisecondsSince(start);
  return answer;
}

}  // namespace waystone
