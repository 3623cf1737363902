// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <iostream>

#include "bench/accuracy/common.h"
#include "bench/accuracy/rgbd_truth.h"
#include "core/base/error.h"

namespace waystone::bench {
namespace {

// Median error of a plane's inlier pixels, transferred to the plane's reference image, against the
// truth; nothing where no inlier has a depth.
std::optional<double> TransferError(const RgbdTruth& truth, int query, int reference,
                                    const RecognisedPlane& plane) {
  std::vector<double> errors;
  for (const Eigen::Vector2d& x : plane.query_points) {
    const auto expected = truth.Transfer(query, x, reference);
    if (!expected) continue;
    errors.push_back((Apply(plane.reference_from_query, x) - *expected).norm());
  }
  if (errors.size() < 5) return std::nullopt;
  return Quantile(errors, 0.5);
}

struct QueryResult {
  bool localized = false;
  std::optional<double> error_px;
};

QueryResult Evaluate(const RgbdTruth& truth, const MapIndex& index, const Answer& answer,
                     int query) {
  QueryResult result;
  result.localized = answer.verdict == Verdict::kLocalized;
  if (!result.localized) return result;
  const RecognisedPlane& best = answer.planes.front();
  const int reference = index.FindKeyframe(best.reference.id)->frame;
  result.error_px = TransferError(truth, query, reference, best);
  return result;
}

}  // namespace

int RunRgbd(const Args& raw) {
  Args args = raw;
  const Range map_range = ParseRange(TakeOption(args, "map", "0:499"));
  const Range queries = ParseRange(TakeOption(args, "queries", "500:990:10"));
  if (args.size() != 1) throw MapError(ErrorCode::kUsage, "rgbd wants one TUM RGB-D folder");
  const RgbdTruth truth(args[0]);
  BuildResult built = BuildRange(args[0], map_range);
  const BuildReport& report = built.report;
  nlohmann::ordered_json json = {{"bench", "rgbd"},
                                 {"frames", report.frames},
                                 {"keyframes", built.map.keyframes.size()},
                                 {"planes", built.map.planes.size()},
                                 {"edges", built.map.edges.size()},
                                 {"features", FeatureCount(built.map)},
                                 {"build_s", report.total_s}};
  std::printf(
      "map: %zu keyframes, %zu planes, %zu edges, %lld features; %d started, %d rejected, "
      "%d merged, %d dropped, %d fused, %d rotation only, %d stretches\n",
      built.map.keyframes.size(), built.map.planes.size(), built.map.edges.size(),
      static_cast<long long>(FeatureCount(built.map)), report.planes_started,
      report.planes_rejected, report.planes_merged, report.planes_dropped, report.planes_fused,
      report.rotation_only, report.stretches);
  if (built.map.verdict)
    std::printf("verdict: %.1f %+.2f log(1+inliers) %+.2f share, %d right, %d wrong\n",
                built.map.verdict->intercept, built.map.verdict->log_inliers,
                built.map.verdict->inlier_share, built.map.verdict->positives,
                built.map.verdict->negatives);
  std::printf("seconds: extract %.1f (all threads), track %.1f, fusion %.2f, total %.1f\n",
              report.extract_s, report.track_s, report.fusion_s, report.total_s);
  const auto index = MapIndex::Build(std::move(built.map));
  int asked = 0;
  int localized = 0;
  int ambiguous = 0;
  std::vector<double> errors;
  std::vector<double> total_ms;
  std::vector<double> shortlist_ms;
  std::vector<double> verify_ms;
  std::vector<double> extract_ms;
  for (int q = queries.from; q <= queries.to; q += queries.step) {
    const Answer answer =
        Localize(*index, ReadBytes(std::filesystem::path(args[0]) / truth.image(q)), truth.image(q),
                 LocalizeOptions{});
    const QueryResult result = Evaluate(truth, *index, answer, q);
    ++asked;
    localized += result.localized;
    ambiguous += answer.verdict == Verdict::kAmbiguous;
    if (result.error_px) errors.push_back(*result.error_px);
    total_ms.push_back(answer.timing.total_ms);
    shortlist_ms.push_back(answer.timing.shortlist_ms);
    verify_ms.push_back(answer.timing.verify_ms);
    extract_ms.push_back(answer.timing.extract_ms);
    const std::string detail =
        result.localized ? "plane " + std::to_string(answer.planes.front().id.value) + ", " +
                               std::to_string(answer.planes.front().inliers) + " inliers, " +
                               std::to_string(answer.planes.size()) + " planes"
                         : answer.message;
    std::printf("%4d %-11s %6.1f px  %s\n", q, NameOf(answer.verdict), result.error_px.value_or(-1),
                detail.c_str());
  }
  const auto within = [&](double limit) {
    return static_cast<int>(
        std::count_if(errors.begin(), errors.end(), [&](double e) { return e <= limit; }));
  };
  json["queries"] = asked;
  json["localized"] = localized;
  json["ambiguous"] = ambiguous;
  json["with_truth"] = errors.size();
  json["within_10px"] = within(10);
  json["within_20px"] = within(20);
  json["median_error_px"] = Quantile(errors, 0.5);
  json["median_ms"] = {{"extract", Quantile(extract_ms, 0.5)},
                       {"shortlist", Quantile(shortlist_ms, 0.5)},
                       {"verify", Quantile(verify_ms, 0.5)},
                       {"total", Quantile(total_ms, 0.5)}};
  std::cout << json.dump() << std::endl;
  return 0;
}

}  // namespace waystone::bench
