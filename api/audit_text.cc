// SPDX-License-Identifier: Apache-2.0
#include "api/audit_text.h"

#include <cmath>
#include <string>

#include "core/base/text.h"

namespace waystone {
namespace {

std::string Counted(int count, const std::string& what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

// To the nearest per cent: unlike with PercentText, which rounds down, no share is compared with a
// threshold here.
std::string RoundedPercent(double share) { return std::to_string(std::lround(100 * share)) + "%"; }

// In the format of `waystone eval`.
std::string SourceOf(const MapIndex& index, KeyframeId id) {
  const Keyframe& keyframe = *index.FindKeyframe(id);
  if (index.map().sequences.size() == 1) return Printable(keyframe.source);
  return Printable(index.FindSequence(keyframe.sequence)->name + ":" + keyframe.source);
}

std::string Advice(const MapIndex& index, const AliasPair& alias) {
  if (alias.remedy == Remedy::kJoin) {
    return "probably one surface mapped twice: record a sequence that moves from one to the other "
           "while keeping it in view, and add it to the map";
  }
  return "put up a unique poster or marker near " + SourceOf(index, alias.a) + " or " +
         SourceOf(index, alias.b) + " and record it again; if both are the same place, record a " +
         "sequence from one to the other instead";
}

std::string Advice(const WeakRun& run) {
  switch (run.remedy) {
    case Remedy::kSlowerPass:
      return "tracking was lost here: record this place again, slower and in better light";
    case Remedy::kMoreViews:
      return "record this place again, slower and from more viewpoints";
    case Remedy::kMarker:
    case Remedy::kJoin:
      return "there is little texture here: put up posters or markers and record it again";
  }
  WS_CHECK(false, "unknown remedy");
}

std::string AliasText(const MapIndex& index, const AliasPair& alias) {
  std::string text = "  " + SourceOf(index, alias.a) + " and " + SourceOf(index, alias.b) + ": " +
                     std::to_string(alias.inliers) + " features in common, " +
                     RoundedPercent(alias.of_view) + " of those in view; planes";
  for (const AliasPlanes& planes : alias.planes) {
    text += " " + std::to_string(planes.a.value) + "/" + std::to_string(planes.b.value);
  }
  return text + "\n    " + Advice(index, alias) + "\n";
}

constexpr const char* kTieAdvice =
    "compare both keyframes: if they show two places, change the appearance of one and rebuild the "
    "map; if they show one place, record a slower pass through it";

std::string TieText(const MapIndex& index, const LoneTie& tie) {
  return "  " + SourceOf(index, tie.a) + " and " + SourceOf(index, tie.b) + ": only plane " +
         std::to_string(tie.plane.value) + ", " + Counted(tie.inliers, "feature") + "\n    " +
         kTieAdvice + "\n";
}

std::string Cause(const WeakRun& run) {
  switch (run.weakness) {
    case Weakness::kSeesNoPlane:
      return "no plane in view";
    case Weakness::kFewFeatures:
      return "only " + Counted(run.features, "feature") + " in view";
    case Weakness::kFewPlanes:
      return "isolated stretch with only " + Counted(run.planes, "plane");
  }
  WS_CHECK(false, "unknown weakness");
}

std::string WeakText(const MapIndex& index, const WeakRun& run) {
  std::string text = "  " + SourceOf(index, run.first);
  if (run.keyframes > 1) text += " to " + SourceOf(index, run.last);
  text += ": " + Cause(run) + " (" + Counted(run.keyframes, "keyframe") + ")";
  return text + "\n    " + Advice(run) + "\n";
}

Json KeyframeJson(const MapIndex& index, KeyframeId id) {
  const Keyframe& keyframe = *index.FindKeyframe(id);
  return {{"id", id.value},
          {"sequence", index.FindSequence(keyframe.sequence)->name},
          {"source", keyframe.source}};
}

Json AliasJson(const MapIndex& index, const AliasPair& alias) {
  Json planes = Json::array();
  for (const AliasPlanes& pair : alias.planes) {
    planes.push_back({{"a", pair.a.value},
                      {"b", pair.b.value},
                      {"inliers", pair.inliers},
                      {"shared", Rounded(pair.shared, 3)}});
  }
  return {{"a", KeyframeJson(index, alias.a)},  {"b", KeyframeJson(index, alias.b)},
          {"inliers", alias.inliers},           {"of_view", Rounded(alias.of_view, 3)},
          {"shared", Rounded(alias.shared, 3)}, {"planes", std::move(planes)},
          {"remedy", NameOf(alias.remedy)},     {"advice", Advice(index, alias)}};
}

Json TieJson(const MapIndex& index, const LoneTie& tie) {
  return {{"plane", tie.plane.value},
          {"a", KeyframeJson(index, tie.a)},
          {"b", KeyframeJson(index, tie.b)},
          {"inliers", tie.inliers},
          {"advice", kTieAdvice}};
}

Json WeakJson(const MapIndex& index, const WeakRun& run) {
  return {{"first", KeyframeJson(index, run.first)},
          {"last", KeyframeJson(index, run.last)},
          {"keyframes", run.keyframes},
          {"planes", run.planes},
          {"features", run.features},
          {"weakness", NameOf(run.weakness)},
          {"remedy", NameOf(run.remedy)},
          {"advice", Advice(run)}};
}

}  // namespace

std::string AuditText(const MapIndex& index, const AuditReport& report) {
  const auto count = [](size_t n) { return static_cast<int>(n); };
  std::string text =
      Counted(count(report.aliases.size()), "pair") + " of perceptually aliased places\n";
  for (const AliasPair& alias : report.aliases) text += AliasText(index, alias);
  text += Counted(count(report.ties.size()), "pair") + " of places connected by a single plane\n";
  for (const LoneTie& tie : report.ties) text += TieText(index, tie);
  text += Counted(count(report.weak.size()), "run") + " of weak keyframes\n";
  for (const WeakRun& run : report.weak) text += WeakText(index, run);
  return text;
}

Json AuditJson(const MapIndex& index, const AuditReport& report) {
  Json json;
  json["aliases"] = Json::array();
  json["ties"] = Json::array();
  json["weak"] = Json::array();
  for (const AliasPair& alias : report.aliases) json["aliases"].push_back(AliasJson(index, alias));
  for (const LoneTie& tie : report.ties) json["ties"].push_back(TieJson(index, tie));
  for (const WeakRun& run : report.weak) json["weak"].push_back(WeakJson(index, run));
  return json;
}

}  // namespace waystone
