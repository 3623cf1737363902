// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "localizer/index/map_index.h"
#include "localizer/verdict/answer.h"
#include "quality/pose_error.h"

// How good answers are, measured on queries whose place is known. All functions are pure;
// thread-safe. docs/evaluation.md defines the figures.
namespace waystone {

// One query after it was answered. `truth` is empty for a query that isn't in the map.
struct ScoredQuery {
  std::vector<PlaceId> truth;
  Answer answer;
  std::optional<PoseError> error;  // of a localized answer, where the true poses are known
  bool has_true_angle = false;     // the orientations of it and of the map's images are known
};

// Whether a place is one of the true ones or next to one: a keyframe that saw a plane which a true
// one also saw, or a panorama that an edge joins to a true one.
bool IsRightPlace(const MapIndex& index, const std::vector<PlaceId>& truth,
                  const PlaceId& answered);

// The best place of an answer, whatever its verdict: the answered one when localized, else the
// first of those that were considered. Nothing where there is none.
std::optional<PlaceId> BestPlace(const Answer& answer);

// What became of a query.
enum class Outcome {
  kRight,          // localized at a true place
  kWrong,          // localized elsewhere, though it is in the map
  kFalseAccept,    // localized, though it isn't in the map
  kMissed,         // in the map, and neither localized nor ambiguous
  kUnsure,         // in the map or not, and ambiguous
  kRightlyRefused  // not in the map, and not localized or ambiguous
};
// "right", "wrong", "false_accept", "missed", "unsure", "rightly_refused".
const char* NameOf(Outcome outcome);
Outcome ClassifyOutcome(const MapIndex& index, const ScoredQuery& query);

// Answers whose stated probability lies in [from, to); the last bin includes 1.
struct ReliabilityBin {
  double from = 0;
  double to = 0;
  int count = 0;
  double stated = 0;    // mean of the stated probabilities; 0 without answers
  double observed = 0;  // share of the answers whose best place is right; 0 without answers
};

struct Percentiles {
  double p50 = 0;
  double p90 = 0;
  double p99 = 0;
};

struct Latency {
  Percentiles decode_ms, extract_ms, shortlist_ms, verify_ms, total_ms;
};

// Distances between the true poses of queries and those of their answers, metres.
struct PositionErrors {
  int count = 0;
  double mean_m = 0;
  double rmse_m = 0;  // root mean square: the error of the trajectory that the answers make
  double median_m = 0;
  double p90_m = 0;
  double max_m = 0;
};

// Shares of the positives that are localized within a distance and an angle. An answer without a
// heading is within no angle; positives of unknown orientation don't count in `pose`.
struct WithinTolerance {
  double metres = 0;
  double degrees = 0;
  double position = 0;         // within the distance, whatever the angle
  std::optional<double> pose;  // within both; nothing where no orientation is known
};

// The tolerances of Sattler et al. (2018), and a finer one for maps with poses.
inline constexpr std::array<std::array<double, 2>, 4> kTolerances = {
    {{0.05, 2}, {0.25, 2}, {0.5, 5}, {5, 10}}};

struct Evaluation {
  int queries = 0;
  int positives = 0;  // in the map
  int negatives = 0;  // not in the map
  int right = 0;
  int wrong = 0;
  int false_accepts = 0;
  int ambiguous_positives = 0;
  int ambiguous_negatives = 0;
  int bad_images = 0;
  std::optional<double> recall;     // right over positives; nothing without positives
  std::optional<double> precision;  // right over all localized; nothing without any
  // The share of the positives that are answered right when only localized answers with a
  // probability above `threshold` count, which is the highest probability of a false one (-1
  // without any). Nothing without positives.
  std::optional<double> recall_at_full_precision;
  double threshold = -1;
  std::vector<ReliabilityBin> reliability;            // of all answers about readable images
  std::vector<ReliabilityBin> reliability_localized;  // of the localized ones
  Latency latency;                                    // of readable images
  std::optional<PositionErrors> position;             // of localized positives whose error is known
  std::vector<WithinTolerance> within;                // kTolerances; empty where none is known
};

// The bins of the reliability tables, of equal width.
inline constexpr int kReliabilityBins = 10;

Evaluation Evaluate(const MapIndex& index, const std::vector<ScoredQuery>& queries);

}  // namespace waystone
