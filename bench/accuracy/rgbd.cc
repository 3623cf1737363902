// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <opencv2/calib3d.hpp>

#include "bench/accuracy/common.h"
#include "bench/accuracy/rgbd_truth.h"
#include "bench/accuracy/settings.h"
#include "bench/baseline/scenes.h"
#include "core/base/error.h"
#include "core/features/features.h"
#include "core/features/match.h"
#include "core/homography/homography.h"
#include "core/image/decode.h"
#include "schema/layers/names/place_names.h"
#include "schema/layers/planes/index_features.h"
#include "schema/layers/planes/surfaces.h"

namespace waystone::bench {
namespace {

// What the images themselves say about the truth: the median error of plain matches of the query
// and the plane's reference image that fit one epipolar geometry. It involves no plane or
// homography, so it is the truth's own error; nothing with fewer than 12 such matches.
std::optional<double> TruthError(const RgbdTruth& truth, const Features& query_features,
                                 const Features& reference_features, int query, int reference) {
  std::vector<cv::Point2f> from;
  std::vector<cv::Point2f> to;
  for (const Match& match :
       MatchDescriptors(query_features.descriptors, reference_features.descriptors,
                        FeatureType::kSift, MatchOptions{})) {
    const Keypoint& a = query_features.keypoints[match.a];
    const Keypoint& b = reference_features.keypoints[match.b];
    from.emplace_back(a.x_px, a.y_px);
    to.emplace_back(b.x_px, b.y_px);
  }
  constexpr int kFewest = 12;
  if (from.size() < kFewest) return std::nullopt;
  cv::Mat fits;
  cv::findFundamentalMat(from, to, cv::FM_RANSAC, 2.0, 0.999, fits);
  std::vector<double> errors;
  for (size_t i = 0; i < from.size() && !fits.empty(); ++i) {
    if (!fits.at<uchar>(static_cast<int>(i))) continue;
    const auto expected = truth.Transfer(query, {from[i].x, from[i].y}, reference);
    if (expected) errors.push_back((Eigen::Vector2d(to[i].x, to[i].y) - *expected).norm());
  }
  if (errors.size() < kFewest) return std::nullopt;
  return Quantile(errors, 0.5);
}

struct Queries {
  int asked = 0;
  int localized = 0;
  int ambiguous = 0;
  std::vector<double> errors_px;  // of the localized ones that have a truth
  // Of pixels inside the best plane's outline: the median error of each of these queries.
  std::vector<double> outline_errors_px;
  std::vector<double> truth_errors_px;  // of plain matches, where there are enough
  std::vector<StageTimes> timing;
};

// Errors of where the best plane's homography takes pixels inside its outline, on a grid; nothing
// where the truth has fewer than 12 of them.
std::optional<double> OutlineError(const RgbdTruth& truth, const RecognisedPlane& plane, int query,
                                   const Keyframe& reference) {
  constexpr double kStep_px = 8;
  constexpr size_t kFewest = 12;
  if (plane.outline.size() < 3) return std::nullopt;
  Eigen::Array2d low = plane.outline.front().array();
  Eigen::Array2d high = low;
  for (const Eigen::Vector2d& x : plane.outline) {
    low = low.min(x.array());
    high = high.max(x.array());
  }
  std::vector<double> errors;
  for (double y = low.y(); y <= high.y(); y += kStep_px) {
    for (double x = low.x(); x <= high.x(); x += kStep_px) {
      const Eigen::Vector2d at(x, y);
      if (!Holds(plane.outline, at)) continue;
      const auto expected = truth.Transfer(query, at, reference.frame);
      if (!expected) continue;
      const Eigen::Vector2d named =
          InImage(Apply(plane.reference_from_query, at), reference.width, RgbdTruth::kWidth_px);
      errors.push_back((named - *expected).norm());
    }
  }
  if (errors.size() < kFewest) return std::nullopt;
  return Quantile(errors, 0.5);
}

void PrintMap(const BuildResult& built) {
  const PlaneReport& report = built.report.planes.value();
  std::printf(
      "map: %zu keyframes, %zu planes, %zu edges, %lld features; %d started, %d rejected, "
      "%d merged, %d dropped, %d fused, %d rotation only, %d stretches\n",
      built.map.keyframes.size(), built.map.planes.size(), built.map.edges.size(),
      static_cast<long long>(CountFeatures(built.map)), report.planes_started,
      report.planes_rejected, report.planes_merged, report.planes_dropped, report.planes_fused,
      report.rotation_only, report.stretches);
  if (built.map.verdict)
    std::printf("verdict: %.1f %+.2f log(1+inliers) %+.2f share, %d right, %d wrong\n",
                built.map.verdict->intercept, built.map.verdict->log_inliers,
                built.map.verdict->inlier_share, built.map.verdict->positives,
                built.map.verdict->negatives);
  std::printf("seconds: extract %.1f (all threads), track %.1f, fusion %.2f, total %.1f\n",
              report.observe_s, report.add_s, report.fusion_s, built.report.total_s);
}

void Ask(const RgbdTruth& truth, const std::filesystem::path& folder, const MapIndex& index,
         int query, Queries& queries) {
  const auto bytes_of = [&](int frame) { return ReadBytes(folder / truth.image(frame)); };
  const auto features_of = [&](int frame) {
    return ExtractFeatures(DecodeGrey(bytes_of(frame)), FeatureOptions{});
  };
  const Answer answer = Localize(index, bytes_of(query), truth.image(query), LocalizeOptions{});
  ++queries.asked;
  queries.timing.push_back(answer.timing);
  queries.ambiguous += answer.verdict == Verdict::kAmbiguous;
  if (answer.verdict != Verdict::kLocalized) {
    std::printf("%4d %-11s %s\n", query, NameOf(answer.verdict), answer.message.c_str());
    return;
  }
  ++queries.localized;
  const SceneAnswer place = SceneAnswerOf(index, answer);
  const int reference = place.reference_frame;
  const auto error_px = truth.MedianError(query, place);
  const auto truth_px =
      TruthError(truth, features_of(query), features_of(reference), query, reference);
  if (error_px) queries.errors_px.push_back(*error_px);
  if (truth_px) queries.truth_errors_px.push_back(*truth_px);
  if (!answer.planes.recognised.empty()) {
    const RecognisedPlane& best = answer.planes.recognised.front();
    const auto outline_px =
        OutlineError(truth, best, query, *index.FindKeyframe(best.reference.id));
    if (outline_px) queries.outline_errors_px.push_back(*outline_px);
  }
  std::printf("%4d %-11s %6.1f px  %d inliers, %zu planes; plain matches %.1f px\n", query,
              NameOf(answer.verdict), error_px.value_or(-1), CountBestInliers(answer.planes),
              answer.planes.recognised.size(), truth_px.value_or(-1));
}

int CountWithin(const std::vector<double>& errors, double limit) {
  return static_cast<int>(
      std::count_if(errors.begin(), errors.end(), [&](double e) { return e <= limit; }));
}

double MedianMs(const Queries& queries, double StageTimes::*stage) {
  std::vector<double> ms;
  for (const StageTimes& timing : queries.timing) ms.push_back(timing.*stage);
  return Quantile(ms, 0.5);
}

}  // namespace

int RunRgbd(const Args& raw) {
  Args args = raw;
  const Range map_range = ParseRange(TakeOption(args, "map", "0:499"));
  const Range range = ParseRange(TakeOption(args, "queries", "500:990:10"));
  const BuildOptions options = TakeBuildSettings(args);
  if (args.size() != 1) throw MapError(ErrorCode::kUsage, "rgbd wants one TUM RGB-D folder");
  const RgbdTruth truth(args[0]);
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(
      OpenSource(args[0], {.every = map_range.step, .from = map_range.from, .to = map_range.to}));
  BuildResult built = BuildMap(sources, options, {});
  PrintMap(built);
  const int surfaces = CountSurfaces(FindSurfaces(built.map.planes, built.map.edges));
  nlohmann::ordered_json json = {
      {"bench", "rgbd"},
      {"frames", built.report.planes.value().frames},
      {"keyframes", built.map.keyframes.size()},
      {"planes", built.map.planes.size()},
      {"surfaces", surfaces},
      {"surfaces_per_keyframe", surfaces / static_cast<double>(built.map.keyframes.size())},
      {"edges", built.map.edges.size()},
      {"features", CountFeatures(built.map)},
      {"build_s", built.report.total_s}};
  const auto index = MapIndex::Build(std::move(built.map));
  Queries queries;
  for (int q = range.from; q <= range.to; q += range.step) Ask(truth, args[0], *index, q, queries);
  json["queries"] = queries.asked;
  json["localized"] = queries.localized;
  json["ambiguous"] = queries.ambiguous;
  json["with_truth"] = queries.errors_px.size();
  json["within_10px"] = CountWithin(queries.errors_px, 10);
  json["within_20px"] = CountWithin(queries.errors_px, 20);
  json["outlines"] = {{"with_truth", queries.outline_errors_px.size()},
                      {"within_10px", CountWithin(queries.outline_errors_px, 10)},
                      {"median_error_px", Quantile(queries.outline_errors_px, 0.5)}};
  json["median_error_px"] = Quantile(queries.errors_px, 0.5);
  json["plain_matches"] = {{"with_truth", queries.truth_errors_px.size()},
                           {"within_10px", CountWithin(queries.truth_errors_px, 10)},
                           {"within_20px", CountWithin(queries.truth_errors_px, 20)}};
  json["median_ms"] = {{"extract", MedianMs(queries, &StageTimes::extract_ms)},
                       {"shortlist", MedianMs(queries, &StageTimes::shortlist_ms)},
                       {"verify", MedianMs(queries, &StageTimes::verify_ms)},
                       {"total", MedianMs(queries, &StageTimes::total_ms)}};
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
