// SPDX-License-Identifier: Apache-2.0
#include "cli/output/eval_text.h"
#include "core/base/text.h"

#include <cstdarg>
#include <cstdio>

namespace waystone {
namespace {

// printf into a string, for tables.
__attribute__((format(printf, 1, 2))) std::string Format(const char* format, ...) {
  char line[400];
  std::va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(line, sizeof line, format, arguments);
  va_end(arguments);
  return line;
}

// "  83.3%"; "-" for a share of none.
std::string ShareText(const std::optional<double>& share) {
  return share ? Format("%6.1f%%", 100 * *share) : Format("%7s", "-");
}

Json ShareJson(const std::optional<double>& share) {
  return share ? Json(Rounded(*share, 4)) : Json(nullptr);
}

std::string CountsLines(const Evaluation& e) {
  std::string text =
      Format("%d queries: %d in the map, %d not\n\n", e.queries, e.positives, e.negatives);
  text += "  recall                 " + ShareText(e.recall) +
          Format("  %d of %d localized correctly\n", e.right, e.positives);
  text += "  recall at 100% prec.   " + ShareText(e.recall_at_full_precision) + "  ";
  text += e.threshold < 0 ? std::string("no false answers\n")
                          : Format("at probabilities above %.4f\n", e.threshold);
  text += "  precision              " + ShareText(e.precision) + "\n";
  text += Format("  wrong place            %6d\n", e.wrong);
  text +=
      Format("  false accepts          %6d   of %d not in the map\n", e.false_accepts, e.negatives);
  text += Format("  ambiguous              %6d   in the map, %d not\n", e.ambiguous_positives,
                 e.ambiguous_negatives);
  text += Format("  unreadable images      %6d\n", e.bad_images);
  return text;
}

std::string ReliabilityLines(const Evaluation& e) {
  std::string text =
      "\n  reliability   all answers               localized\n"
      "  probability   count   mean  observed   count   mean  observed\n";
  const auto cells = [](const ReliabilityBin& bin) {
    if (bin.count == 0) return Format("%7d       -        -", 0);
    return Format("%7d %7.3f  %7.3f", bin.count, bin.stated, bin.observed);
  };
  for (int b = 0; b < kReliabilityBins; ++b) {
    const ReliabilityBin& all = e.reliability[b];
    text += Format("  %.1f to %.1f ", all.from, all.to) + cells(all) + " " +
            cells(e.reliability_localized[b]) + "\n";
  }
  return text;
}

struct NamedStage {
  const char* name;
  Percentiles Latency::*times;
};

constexpr NamedStage kStages[] = {{"decode", &Latency::decode_ms},
                                  {"extract", &Latency::extract_ms},
                                  {"shortlist", &Latency::shortlist_ms},
                                  {"verify", &Latency::verify_ms},
                                  {"total", &Latency::total_ms}};

std::string LatencyLines(const Latency& latency) {
  std::string text = "\n  latency (ms)     p50      p90      p99\n";
  for (const NamedStage& stage : kStages) {
    const Percentiles& times = latency.*stage.times;
    text += Format("  %-10s  %8.1f %8.1f %8.1f\n", stage.name, times.p50, times.p90, times.p99);
  }
  return text;
}

std::string PositionLines(const PositionErrors& p) {
  return Format(
      "\n  distance to the returned place (m), %d answers\n"
      "  rmse %.2f  mean %.2f  median %.2f  p90 %.2f  max %.2f\n",
      p.count, p.rmse_m, p.mean_m, p.median_m, p.p90_m, p.max_m);
}

std::string ToleranceLines(const std::vector<WithinTolerance>& within) {
  std::string text = "\n  of those in the map, localized within\n";
  for (const WithinTolerance& share : within) {
    text += Format("  %4.2f m %6.1f%%, and %4.0f degrees ", share.metres, 100 * share.position,
                   share.degrees) +
            ShareText(share.pose) + "\n";
  }
  return text;
}

Json TolerancesJson(const std::vector<WithinTolerance>& within) {
  Json list = Json::array();
  for (const WithinTolerance& share : within) {
    list.push_back({{"metres", share.metres},
                    {"degrees", share.degrees},
                    {"position", Rounded(share.position, 4)},
                    {"pose", ShareJson(share.pose)}});
  }
  return list;
}

Json BinsJson(const std::vector<ReliabilityBin>& bins) {
  Json list = Json::array();
  for (const ReliabilityBin& bin : bins) {
    list.push_back({{"from", bin.from},
                    {"to", bin.to},
                    {"count", bin.count},
                    {"stated", bin.count == 0 ? Json(nullptr) : Json(Rounded(bin.stated, 4))},
                    {"observed", bin.count == 0 ? Json(nullptr) : Json(Rounded(bin.observed, 4))}});
  }
  return list;
}

Json LatencyJson(const Latency& latency) {
  Json json;
  for (const NamedStage& stage : kStages) {
    const Percentiles& times = latency.*stage.times;
    json[stage.name] = {{"p50", Rounded(times.p50, 2)},
                        {"p90", Rounded(times.p90, 2)},
                        {"p99", Rounded(times.p99, 2)}};
  }
  return json;
}

Json PositionJson(const PositionErrors& p) {
  return {{"count", p.count},
          {"rmse", Rounded(p.rmse_m, 4)},
          {"mean", Rounded(p.mean_m, 4)},
          {"median", Rounded(p.median_m, 4)},
          {"p90", Rounded(p.p90_m, 4)},
          {"max", Rounded(p.max_m, 4)}};
}

}  // namespace

std::string EvaluationText(const Evaluation& evaluation) {
  std::string text =
      CountsLines(evaluation) + ReliabilityLines(evaluation) + LatencyLines(evaluation.latency);
  if (evaluation.position) {
    text += PositionLines(*evaluation.position) + ToleranceLines(evaluation.within);
  }
  return text;
}

Json EvaluationJson(const Evaluation& e) {
  Json json;
  json["queries"] = e.queries;
  json["positives"] = e.positives;
  json["negatives"] = e.negatives;
  json["right"] = e.right;
  json["wrong"] = e.wrong;
  json["false_accepts"] = e.false_accepts;
  json["ambiguous"] = {{"positives", e.ambiguous_positives}, {"negatives", e.ambiguous_negatives}};
  json["bad_images"] = e.bad_images;
  json["recall"] = ShareJson(e.recall);
  json["precision"] = ShareJson(e.precision);
  json["recall_at_full_precision"] = ShareJson(e.recall_at_full_precision);
  json["threshold"] = e.threshold < 0 ? Json(nullptr) : Json(e.threshold);
  json["reliability"] = BinsJson(e.reliability);
  json["reliability_localized"] = BinsJson(e.reliability_localized);
  json["latency_ms"] = LatencyJson(e.latency);
  json["position_m"] = e.position ? PositionJson(*e.position) : Json(nullptr);
  json["within"] = TolerancesJson(e.within);
  return json;
}

std::string MistakesText(const MapIndex& index, const std::vector<ScoredQuery>& queries) {
  std::string text;
  for (const ScoredQuery& query : queries) {
    const Outcome outcome = ClassifyOutcome(index, query);
    if (outcome != Outcome::kWrong && outcome != Outcome::kFalseAccept) continue;
    const std::string truth = query.truth.empty()
                                  ? "not in the map"
                                  : "true place: near " + SourceOf(index, query.truth.front());
    text += "  " +
            Printable(query.answer.image + ": localized near " + PlaceOf(query.answer)->image +
                      Format(" with probability %.4f, ", query.answer.probability) + truth) +
            "\n";
  }
  return text.empty() ? text : "\nfalse answers\n" + text;
}

Json FailuresJson(const MapIndex& index, const std::vector<ScoredQuery>& queries) {
  Json list = Json::array();
  for (const ScoredQuery& query : queries) {
    const Outcome outcome = ClassifyOutcome(index, query);
    if (outcome == Outcome::kRight || outcome == Outcome::kRightlyRefused) continue;
    const std::optional<PlaceId> place = BestPlace(query.answer);
    Json truth = Json::array();
    for (const PlaceId& id : query.truth) truth.push_back(SourceOf(index, id));
    list.push_back({{"image", query.answer.image},
                    {"outcome", NameOf(outcome)},
                    {"verdict", NameOf(query.answer.verdict)},
                    {"probability", Rounded(query.answer.probability, 6)},
                    {"best", place ? Json(SourceOf(index, *place)) : Json(nullptr)},
                    {"truth", std::move(truth)}});
  }
  return list;
}

}  // namespace waystone
