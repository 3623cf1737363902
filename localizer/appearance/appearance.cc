// SPDX-License-Identifier: Apache-2.0
#include "localizer/appearance/appearance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/check.h"
#include "core/base/clock.h"
#include "core/base/error.h"
#include "core/camera/panorama.h"
#include "localizer/appearance/panorama_series.h"
#include "localizer/verdict/logistic_fit.h"

namespace waystone {
namespace {

bool KeepsFeatures(const AppearanceLayer& layer) {
  return std::ranges::any_of(layer.nodes,
                             [](const auto& node) { return !node.features.bearings.empty(); });
}

// Refines the best node's heading by the warping search, which tolerates motion.
void RefineHeading(const MapIndex& index, const FourierSignature& query, ComparedNode& best,
                   const PanoramaQueryOptions& options) {
  const AppearanceNode& node = index.map().appearance->nodes[best.node];
  CompassOptions compass = options.compass;
  compass.band = index.map().appearance->described.band;
  const CompassHeading heading = RelativeHeading(node.signature, query, compass);
  best.heading_rad = WrappedAngle(node.pose.theta_rad + heading.heading_rad);
  best.sigma_rad = heading.sigma_rad;
}

// Adds the candidates with their probabilities, best first, and the best one elsewhere. Returns the
// probability of the first: a panorama was taken at one place, so the best one elsewhere reduces
// it.
double AddCandidates(const MapIndex& index, const std::vector<ComparedNode>& nodes, bool verified,
                     const AppearanceVerdict& model, const PanoramaQueryOptions& options,
                     PanoramaAnswer& panorama) {
  const AppearanceLayer& layer = *index.map().appearance;
  const auto log_odds = [&](size_t at) {
    AppearanceEvidence evidence = CollectEvidence(index, nodes, at, options);
    evidence.verified = verified;
    return EstimateLogOdds(evidence, model);
  };
  double rival = -std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < nodes.size(); ++i) {
    panorama.candidates.push_back({RefOf(index, layer.nodes[nodes[i].node]), Logistic(log_odds(i)),
                                   nodes[i].cost, nodes[i].inliers, nodes[i].query_from_node});
    if (!AreElsewhere(index, nodes[0].node, nodes[i].node, options)) continue;
    if (!panorama.runner_up) panorama.runner_up = panorama.candidates.back();
    rival = std::max(rival, log_odds(i));
  }
  return ProbabilityAgainst(log_odds(0), rival);
}

// Why the best candidate isn't believed.
std::string DescribeRefusal(const ComparedNode& best, const Answer& answer,
                            const PanoramaQueryOptions& options) {
  const bool verified = answer.decided_by == DecidedBy::kPanoramaFeatures;
  if (verified && best.inliers == 0) {
    return "the features of no mapped panorama fit this image; map the place or send another one";
  }
  const std::string& source = answer.panorama->candidates.front().node.source;
  const std::string evidence =
      verified ? std::to_string(best.inliers) + " of its features fit this image"
               : "its appearance is the most similar";
  return "the best panorama is " + source + ", " + evidence + ": probability " +
         PercentText(answer.probability) + ", required " + PercentText(options.min_probability) +
         "; map the place or send another image";
}

// The verdict of the candidates.
void Judge(const MapIndex& index, const std::vector<ComparedNode>& nodes, bool verified,
           const PanoramaQueryOptions& options, Answer& answer) {
  const AppearanceVerdict model = VerdictFor(*index.map().appearance, verified);
  answer.probability =
      AddCandidates(index, nodes, verified, model, options, answer.panorama.emplace());
  answer.decided_by = verified ? DecidedBy::kPanoramaFeatures : DecidedBy::kPanoramaSignature;
  if (answer.probability >= options.min_probability) {
    answer.verdict = Verdict::kLocalized;
    return;
  }
  // Whether the place would have been believed without the similar one elsewhere.
  AppearanceEvidence alone = CollectEvidence(index, nodes, 0, options);
  alone.verified = verified;
  alone.margin = options.max_margin;
  alone.log_inlier_margin = alone.log_inliers;
  const bool alike =
      answer.panorama->runner_up && EstimateProbability(alone, model) >= options.min_probability;
  answer.verdict = alike ? Verdict::kAmbiguous : Verdict::kNotInMap;
  answer.message = alike ? "several mapped places match this image; move on and send a series"
                         : DescribeRefusal(nodes.front(), answer, options);
}

bool HasShapeOf(const LayerMirror& mirror, const cv::Size& size) {
  constexpr double kTolerance = 0.02;  // an image of another size is rounded to whole pixels
  const double ratio = static_cast<double>(size.width) * mirror.height /
                       (static_cast<double>(std::max(1, size.height)) * mirror.width);
  return std::abs(ratio - 1) <= kTolerance;
}

// Converts an image to a panorama in the same way as the layer's own.
Panorama ToLayersPanorama(const AppearanceLayer& layer, const cv::Mat& grey) {
  PanoramaOptions options;
  if (layer.mirror && HasShapeOf(*layer.mirror, grey.size())) {
    const LayerMirror& mirror = *layer.mirror;
    options.columns = mirror.columns;
    options.mirror_band = mirror.band;
    options.mirror_clockwise = mirror.clockwise;
    options.mirror = mirror.ring;
    if (mirror.ring) {
      options.mirror = ScaledRing(*mirror.ring, static_cast<double>(grey.cols) / mirror.width);
      if (options.mirror->outer_px < options.mirror->inner_px + 1) {
        throw MapError(ErrorCode::kBadImage,
                       "the image is too small for the map's mirror, whose radii differ by less "
                       "than a pixel in it; send it in the size of the mapped ones");
      }
    }
  }
  return ToPanorama(grey, options);
}

PanoramaQuery DescribeAppearance(const MapIndex& index, const cv::Mat& grey) {
  WS_CHECK(index.HasAppearance(), "the map has no appearance layer");
  const AppearanceLayer& layer = *index.map().appearance;
  const Panorama panorama = ToLayersPanorama(layer, grey);
  if (!BandsAgree(UsedBand(panorama, layer.described), layer.described.band)) {
    throw MapError(ErrorCode::kBadImage,
                   "the panorama doesn't show all elevations of the map's; send a panorama by a "
                   "camera with the same or a larger vertical field of view");
  }
  PanoramaQuery query;
  query.signature = Signature(panorama, layer.described);
  return query;
}

BearingFeatures ExtractQueryFeatures(const MapIndex& index, const cv::Mat& grey,
                                     const PanoramaQueryOptions& options) {
  PanoramaFeatureOptions features = options.features;
  features.bearings.features.type = index.map().info.feature_type;
  return ExtractScaledPanorama(grey, features);
}

// Whether the place is sure by appearance only.
bool IsSettled(const MapIndex& index, const std::vector<ComparedNode>& nodes,
               const PanoramaQueryOptions& options) {
  if (nodes.empty()) return true;
  const AppearanceEvidence evidence = CollectEvidence(index, nodes, 0, options);
  const AppearanceVerdict model = VerdictFor(*index.map().appearance, false);
  return EstimateProbability(evidence, model) >= options.settled_probability;
}

}  // namespace

bool IsForPanoramas(const MapIndex& index, const cv::Size& size) {
  if (!index.HasAppearance()) return false;
  const auto& mirror = index.map().appearance->mirror;
  return HasPanoramaShape(size) || (mirror && HasShapeOf(*mirror, size));
}

bool MayBePhoto(const MapIndex& index, const cv::Size& size) {
  return index.HasKeyframeFeatures() && !HasPanoramaShape(size);
}

MirrorRing ScaledRing(const MirrorRing& ring, double factor) {
  const cv::Point2d half(0.5, 0.5);  // pixels' centres are at whole numbers
  return {(ring.centre_px + half) * factor - half, ring.inner_px * factor, ring.outer_px * factor};
}

PanoramaQuery DescribeQuery(const MapIndex& index, const cv::Mat& grey,
                            const PanoramaQueryOptions& options) {
  PanoramaQuery query = DescribeAppearance(index, grey);
  if (options.verify && KeepsFeatures(*index.map().appearance)) {
    query.features = ExtractQueryFeatures(index, grey, options);
  }
  return query;
}

Answer JudgeNodes(const MapIndex& index, const FourierSignature& query,
                  std::vector<ComparedNode> nodes, bool verified,
                  const PanoramaQueryOptions& options) {
  Answer answer;
  if (nodes.empty()) {
    answer.message = "the appearance layer has no other node to compare with; map more places";
    return answer;
  }
  if (nodes.front().inliers == 0 && options.fine_heading) {
    RefineHeading(index, query, nodes.front(), options);
  }
  Judge(index, nodes, verified, options, answer);
  TakePlace(index, nodes, options, 0, *answer.panorama);
  answer.panorama->metres_per_unit = index.map().appearance->metres_per_unit;
  if (answer.verdict == Verdict::kLocalized) {
    const double heading_rad = answer.panorama->pose.theta_rad;
    answer.heading = Heading{heading_rad, nodes.front().sigma_rad, HeadingFrame::kLayer};
  }
  return answer;
}

Answer LocatePanorama(const MapIndex& index, const PanoramaQuery& query,
                      const PanoramaQueryOptions& options, const std::vector<bool>& left_out) {
  options.Check();
  WS_CHECK(index.HasAppearance(), "the map has no appearance layer");
  const auto start = Clock::now();
  Answer answer = JudgeNodes(index, query.signature, CompareQuery(index, query, options, left_out),
                             query.features.has_value(), options);
  answer.timing.verify_ms = answer.timing.total_ms = MillisecondsSince(start);
  return answer;
}

namespace {

// The answer to a panorama; `extract` returns its features and is called only where the appearance
// doesn't settle the place.
template <typename Extract>
Answer LocalizeInSteps(const MapIndex& index, PanoramaQuery query, bool may_verify,
                       const Extract& extract, const PanoramaQueryOptions& options) {
  PanoramaQueryOptions alone = options;
  alone.verify = false;
  std::vector<ComparedNode> nodes = CompareQuery(index, query, alone, {});
  if (may_verify && !IsSettled(index, nodes, options)) {
    query.features = extract();
    nodes = CompareQuery(index, query, options, {});
  }
  const bool verified = query.features.has_value();
  Answer answer = JudgeNodes(index, query.signature, nodes, verified, options);
  SeriesOptions series;
  series.query = options;
  if (answer.verdict != Verdict::kNotInMap) {
    answer.belief = BeliefAfter(index, nodes, verified, {}, series);
  }
  return answer;
}

}  // namespace

Answer LocalizeDescribed(const MapIndex& index, const PanoramaQuery& query,
                         const PanoramaQueryOptions& options) {
  options.Check();
  return LocalizeInSteps(
      index, {query.signature, std::nullopt}, options.verify && query.features.has_value(),
      [&] { return *query.features; }, options);
}

Answer LocalizePanorama(const MapIndex& index, const cv::Mat& grey,
                        const PanoramaQueryOptions& options) {
  options.Check();
  const auto start = Clock::now();
  try {
    const PanoramaQuery query = DescribeAppearance(index, grey);
    double extract_ms = MillisecondsSince(start);
    const auto extract = [&] {
      LapTimer timer;
      BearingFeatures features = ExtractQueryFeatures(index, grey, options);
      extract_ms += timer.Lap();
      return features;
    };
    const bool may_verify = options.verify && KeepsFeatures(*index.map().appearance);
    Answer answer = LocalizeInSteps(index, query, may_verify, extract, options);
    answer.timing.extract_ms = extract_ms;
    answer.timing.total_ms = MillisecondsSince(start);
    answer.timing.verify_ms = answer.timing.total_ms - extract_ms;
    return answer;
  } catch (const MapError& error) {
    if (error.code() != ErrorCode::kBadImage) throw;
    Answer answer = RefuseImage(error);
    answer.timing.extract_ms = answer.timing.total_ms = MillisecondsSince(start);
    return answer;
  }
}

}  // namespace waystone
