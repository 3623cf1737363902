// SPDX-License-Identifier: Apache-2.0
#include "quality/evaluation.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/check.h"
#include "core/geometry/angle.h"
#include "core/robust/quantile.h"

namespace waystone {
namespace {

bool Saw(const Plane& plane, KeyframeId keyframe) {
  return std::any_of(plane.views.begin(), plane.views.end(),
                     [&](const PlaneView& view) { return view.keyframe == keyframe; });
}

bool ShareSomePlane(const MapIndex& index, KeyframeId a, KeyframeId b) {
  return std::ranges::any_of(index.map().planes,
                             [&](const Plane& plane) { return Saw(plane, a) && Saw(plane, b); });
}

bool AreJoined(const MapIndex& index, AppearanceNodeId a, AppearanceNodeId b) {
  return std::ranges::any_of(index.map().appearance->edges, [&](const AppearanceEdge& edge) {
    return edge.a == std::min(a, b) && edge.b == std::max(a, b);
  });
}

struct StatedAnswer {
  double probability = 0;
  bool right = false;
};

std::vector<ReliabilityBin> Binned(const std::vector<StatedAnswer>& answers) {
  std::vector<ReliabilityBin> bins(kReliabilityBins);
  for (int b = 0; b < kReliabilityBins; ++b) {
    bins[b].from = static_cast<double>(b) / kReliabilityBins;
    bins[b].to = static_cast<double>(b + 1) / kReliabilityBins;
  }
  for (const StatedAnswer& answer : answers) {
    const int b = std::clamp(static_cast<int>(answer.probability * kReliabilityBins), 0,
                             kReliabilityBins - 1);
    ++bins[b].count;
    bins[b].stated += answer.probability;
    bins[b].observed += answer.right;
  }
  for (ReliabilityBin& bin : bins) {
    bin.stated /= std::max(1, bin.count);
    bin.observed /= std::max(1, bin.count);
  }
  return bins;
}

void MeasureReliability(const MapIndex& index, const std::vector<ScoredQuery>& queries,
                        Evaluation& evaluation) {
  std::vector<StatedAnswer> all;
  std::vector<StatedAnswer> localized;
  for (const ScoredQuery& query : queries) {
    if (query.answer.verdict == Verdict::kBadImage) continue;
    const std::optional<PlaceId> place = BestPlace(query.answer);
    all.push_back({query.answer.probability, place && IsRightPlace(index, query.truth, *place)});
    if (query.answer.verdict == Verdict::kLocalized) localized.push_back(all.back());
  }
  evaluation.reliability = Binned(all);
  evaluation.reliability_localized = Binned(localized);
}

Percentiles ComputePercentiles(const std::vector<ScoredQuery>& queries, double StageTimes::*stage) {
  std::vector<double> times;
  for (const ScoredQuery& query : queries) {
    if (query.answer.verdict != Verdict::kBadImage) times.push_back(query.answer.timing.*stage);
  }
  return {Quantile(times, 0.5), Quantile(times, 0.9), Quantile(times, 0.99)};
}

Latency SummarizeLatency(const std::vector<ScoredQuery>& queries) {
  return {ComputePercentiles(queries, &StageTimes::decode_ms),
          ComputePercentiles(queries, &StageTimes::extract_ms),
          ComputePercentiles(queries, &StageTimes::shortlist_ms),
          ComputePercentiles(queries, &StageTimes::verify_ms),
          ComputePercentiles(queries, &StageTimes::total_ms)};
}

std::optional<PositionErrors> PositionsOf(const std::vector<ScoredQuery>& queries) {
  std::vector<double> errors;
  for (const ScoredQuery& query : queries) {
    const bool counts = query.answer.verdict == Verdict::kLocalized && !query.truth.empty();
    if (counts && query.error) errors.push_back(query.error->metres);
  }
  if (errors.empty()) return std::nullopt;
  const auto count = static_cast<double>(errors.size());
  PositionErrors position;
  position.count = static_cast<int>(errors.size());
  position.mean_m = std::accumulate(errors.begin(), errors.end(), 0.0) / count;
  position.rmse_m =
      std::sqrt(std::inner_product(errors.begin(), errors.end(), errors.begin(), 0.0) / count);
  position.median_m = Quantile(errors, 0.5);
  position.p90_m = Quantile(errors, 0.9);
  position.max_m = Quantile(errors, 1.0);
  return position;
}

// Nothing for a share of none.
std::optional<double> ShareOf(std::ptrdiff_t part, std::ptrdiff_t all) {
  if (all == 0) return std::nullopt;
  return static_cast<double>(part) / static_cast<double>(all);
}

std::vector<WithinTolerance> MeasureTolerances(const std::vector<ScoredQuery>& queries) {
  const auto is_positive = [](const ScoredQuery& query) { return !query.truth.empty(); };
  const auto positives = std::ranges::count_if(queries, is_positive);
  const auto oriented = std::ranges::count_if(queries, [&](const ScoredQuery& query) {
    return is_positive(query) && query.has_true_angle;
  });
  std::vector<WithinTolerance> within;
  for (const auto& [metres, degrees] : kTolerances) {
    int position = 0;
    int pose = 0;
    for (const ScoredQuery& query : queries) {
      if (!is_positive(query) || !query.error || query.error->metres > metres) continue;
      ++position;
      const std::optional<double>& rad = query.error->rad;
      pose += query.has_true_angle && rad && *rad <= degrees * kDegree;
    }
    within.push_back(
        {metres, degrees, ShareOf(position, positives).value_or(0), ShareOf(pose, oriented)});
  }
  return within;
}

void Count(Outcome outcome, const ScoredQuery& query, Evaluation& evaluation) {
  const bool positive = !query.truth.empty();
  ++(positive ? evaluation.positives : evaluation.negatives);
  evaluation.right += outcome == Outcome::kRight;
  evaluation.wrong += outcome == Outcome::kWrong;
  evaluation.false_accepts += outcome == Outcome::kFalseAccept;
  if (outcome == Outcome::kUnsure) {
    ++(positive ? evaluation.ambiguous_positives : evaluation.ambiguous_negatives);
  }
  evaluation.bad_images += query.answer.verdict == Verdict::kBadImage;
}

}  // namespace

bool IsRightPlace(const MapIndex& index, const std::vector<PlaceId>& truth,
                  const PlaceId& answered) {
  if (std::find(truth.begin(), truth.end(), answered) != truth.end()) return true;
  return std::ranges::any_of(truth, [&](const PlaceId& place) {
    if (place.layer != answered.layer) return false;
    return place.layer == PlaceLayer::kPlanes ? ShareSomePlane(index, {place.id}, {answered.id})
                                              : AreJoined(index, {place.id}, {answered.id});
  });
}

std::optional<PlaceId> BestPlace(const Answer& answer) {
  if (const auto place = PlaceOf(answer)) return PlaceId{place->layer, place->id};
  if (answer.panorama && !answer.panorama->candidates.empty()) {
    return PlaceIdOf(answer.panorama->candidates.front().node.id);
  }
  if (!answer.planes.places.empty()) return PlaceIdOf(answer.planes.places.front().keyframe.id);
  if (answer.planes.runner_up) return PlaceIdOf(answer.planes.runner_up->keyframe.id);
  return std::nullopt;
}

const char* NameOf(Outcome outcome) {
  switch (outcome) {
    case Outcome::kRight:
      return "right";
    case Outcome::kWrong:
      return "wrong";
    case Outcome::kFalseAccept:
      return "false_accept";
    case Outcome::kMissed:
      return "missed";
    case Outcome::kUnsure:
      return "unsure";
    case Outcome::kRightlyRefused:
      return "rightly_refused";
  }
  WS_CHECK(false, "unknown outcome");
}

Outcome ClassifyOutcome(const MapIndex& index, const ScoredQuery& query) {
  const bool positive = !query.truth.empty();
  if (query.answer.verdict == Verdict::kAmbiguous) return Outcome::kUnsure;
  if (query.answer.verdict != Verdict::kLocalized) {
    return positive ? Outcome::kMissed : Outcome::kRightlyRefused;
  }
  const std::optional<PlaceId> place = BestPlace(query.answer);
  WS_CHECK(place.has_value(), "localized without a place");
  if (!positive) return Outcome::kFalseAccept;
  return IsRightPlace(index, query.truth, *place) ? Outcome::kRight : Outcome::kWrong;
}

Evaluation Evaluate(const MapIndex& index, const std::vector<ScoredQuery>& queries) {
  Evaluation evaluation;
  evaluation.queries = static_cast<int>(queries.size());
  std::vector<double> right;  // probabilities
  for (const ScoredQuery& query : queries) {
    const Outcome outcome = ClassifyOutcome(index, query);
    Count(outcome, query, evaluation);
    if (outcome == Outcome::kRight) right.push_back(query.answer.probability);
    if (outcome == Outcome::kWrong || outcome == Outcome::kFalseAccept) {
      evaluation.threshold = std::max(evaluation.threshold, query.answer.probability);
    }
  }
  const int localized = evaluation.right + evaluation.wrong + evaluation.false_accepts;
  evaluation.recall = ShareOf(evaluation.right, evaluation.positives);
  evaluation.precision = ShareOf(evaluation.right, localized);
  const auto sure = std::count_if(right.begin(), right.end(), [&](double probability) {
    return probability > evaluation.threshold;
  });
  evaluation.recall_at_full_precision = ShareOf(sure, evaluation.positives);
  MeasureReliability(index, queries, evaluation);
  evaluation.latency = SummarizeLatency(queries);
  evaluation.position = PositionsOf(queries);
  if (evaluation.position) evaluation.within = MeasureTolerances(queries);
  return evaluation;
}

}  // namespace waystone
