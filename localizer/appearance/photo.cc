// SPDX-License-Identifier: Apache-2.0
#include "localizer/appearance/photo.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/base/check.h"
#include "core/base/clock.h"
#include "core/camera/rig.h"
#include "localizer/appearance/appearance.h"
#include "localizer/verdict/answer.h"

namespace waystone {
namespace {

// Why a photo can't be localized; empty if it can.
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

BearingFeatures ExtractPhotoRays(const cv::Mat& grey, const Camera& camera, FeatureType type,
                                 const PanoramaQueryOptions& options) {
  BearingFeatureOptions bearings = options.features.bearings;
  bearings.features.type = type;
  bearings.features.max_features = bearings.max_kept = options.photo_features;
  return ExtractBearings(RigOfOne(camera), std::vector<cv::Mat>{grey}, bearings);
}

// The nodes to match with; a photo has no signature with which to rank them further.
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

// The nodes of one place that agree on the photo's heading, the group with the most inliers, best
// first. A photo that sees a single wall fits two motions to each node; two nodes seldom agree in
// the wrong ones.
std::vector<ComparedNode> SelectAgreeing(const MapIndex& index,
                                         const std::vector<ComparedNode>& nodes,
                                         const PanoramaQueryOptions& options) {
  std::vector<ComparedNode> best;
  int most = 0;
  for (const ComparedNode& one : nodes) {
    std::vector<ComparedNode> agreeing;
    int inliers = 0;
    for (const ComparedNode& other : nodes) {
      if (other.inliers == 0 || AreElsewhere(index, one.node, other.node, options)) continue;
      const double off = std::abs(WrappedAngle(other.heading_rad - one.heading_rad));
      if (off > options.photo_agreement_rad) continue;
      agreeing.push_back(other);
      inliers += other.inliers;
    }
    if (one.inliers == 0 || inliers <= most) continue;
    most = inliers;
    best = std::move(agreeing);
  }
  std::erase_if(best, [&](const ComparedNode& node) {
    return AreElsewhere(index, best.front().node, node.node, options);
  });
  return best;
}

// The answer by the nodes that agree, among all that were verified.
Answer JudgeAgreeing(const MapIndex& index, const std::vector<ComparedNode>& verified,
                     const PanoramaQueryOptions& options) {
  std::vector<ComparedNode> nodes = SelectAgreeing(index, verified, options);
  if (std::ssize(nodes) >= options.photo_witnesses) {
    // Similar places, whatever the photo's heading there.
    const int best = nodes.front().node;
    std::ranges::copy_if(verified, std::back_inserter(nodes), [&](const ComparedNode& node) {
      return node.inliers > 0 && AreElsewhere(index, best, node.node, options);
    });
    PanoramaQueryOptions rays_alone = options;
    rays_alone.fine_heading = false;  // a photo has no signature
    Answer answer = JudgeNodes(index, {}, nodes, true, rays_alone);
    answer.decided_by = DecidedBy::kPhotoFeatures;
    return answer;
  }
  Answer answer;
  answer.decided_by = DecidedBy::kPhoto;
  answer.message = "fewer than two mapped panoramas match this photo; step back or send a panorama";
  return answer;
}

// What comes after the features, with its times.
Answer AskNodes(const MapIndex& index, const BearingFeatures& query,
                const PanoramaQueryOptions& options, const Deadline& deadline,
                const std::vector<bool>& left_out) {
  if (HasPassed(deadline)) return Undecided(Stage::kExtract);
  const auto start = Clock::now();
  std::vector<ComparedNode> nodes = NodesToAsk(index, query, options, left_out);
  const double shortlist_ms = MillisecondsSince(start);
  PanoramaQueryOptions asked = options;
  asked.max_poses = std::max(asked.max_poses, asked.photo_poses);
  nodes = VerifyByFeatures(index, query, std::move(nodes), asked, deadline);
  Answer answer =
      HasPassed(deadline) ? Undecided(Stage::kShortlist) : JudgeAgreeing(index, nodes, options);
  answer.timing.shortlist_ms = shortlist_ms;
  answer.timing.verify_ms = MillisecondsSince(start) - shortlist_ms;
  return answer;
}

}  // namespace

Answer LocalizePhoto(const MapIndex& index, const cv::Mat& grey,
                     const std::optional<Camera>& camera, const PanoramaQueryOptions& options,
                     const Deadline& deadline, const std::vector<bool>& left_out) {
  options.Check();
  WS_CHECK(index.HasAppearance(), "the map has no appearance layer");
  const auto start = Clock::now();
  Answer answer;
  answer.decided_by = DecidedBy::kPhoto;
  answer.message = WhyNotAnswered(index, grey, camera);
  if (answer.message.empty()) {
    const BearingFeatures query =
        ExtractPhotoRays(grey, *camera, index.map().info.feature_type, options);
    const double extract_ms = MillisecondsSince(start);
    answer = AskNodes(index, query, options, deadline, left_out);
    answer.timing.extract_ms = extract_ms;
  }
  answer.timing.total_ms = MillisecondsSince(start);
  return answer;
}

}  // namespace waystone
