// SPDX-License-Identifier: Apache-2.0
#include "cli/output/build_text.h"
#include "core/base/text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "core/geometry/angle.h"
#include "schema/layers/orientation/unknown_corridors.h"
#include "schema/layers/planes/surfaces.h"

namespace waystone {
namespace {

constexpr int kLabelWidth = 12;

size_t FeatureCount(const MapData& map) {
  size_t count = 0;
  for (const Plane& plane : map.planes) count += plane.features.size();
  return count;
}

size_t LandmarkCount(const MapData& map) {
  size_t count = 0;
  for (const Keyframe& keyframe : map.keyframes) count += keyframe.landmarks.positions.size();
  return count;
}

size_t LoopCount(const AppearanceLayer& layer) {
  return static_cast<size_t>(
      std::ranges::count(layer.edges, AppearanceEdgeKind::kLoop, &AppearanceEdge::kind));
}

size_t LoopCount(const OrientationLayer& layer) {
  return static_cast<size_t>(
      std::ranges::count(layer.edges, OrientationEdgeKind::kLoop, &OrientationEdge::kind));
}

size_t TurnCount(const OrientationLayer& layer) {
  return static_cast<size_t>(std::ranges::count(layer.turns, true, &OrientationTurn::confirmed));
}

size_t ReliableCount(const OrientationLayer& layer) {
  return static_cast<size_t>(std::ranges::count(layer.frames, true, &OrientationFrame::reliable));
}

std::string Plural(size_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

std::string Digits(double value, int count) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(count) << value;
  return text.str();
}

std::string Seconds(double seconds) { return Digits(seconds, 1); }

void Line(std::ostream& out, const std::string& label, const std::string& text) {
  out << "  " << std::left << std::setw(kLabelWidth) << label << Printable(text) << '\n';
}

std::string PlanesText(const PlaneReport& report) {
  return std::to_string(report.planes_started) + " created, " +
         std::to_string(report.planes_rejected) + " rejected and " +
         std::to_string(report.planes_merged) + " merged by the homology test, " +
         std::to_string(report.planes_fused) + " fused, " + std::to_string(report.planes_dropped) +
         " dropped";
}

// "3 of 5 used, 2 skipped" and what the layer adds to that, then the skipped frames by name.
void FramesLines(std::ostream& out, const std::string& label, const FrameReport& report,
                 const std::string& more) {
  Line(out, label,
       std::to_string(report.frames - report.skipped) + " of " + std::to_string(report.frames) +
           " used, " + std::to_string(report.skipped) + " skipped" + more);
  for (const std::string& name : report.skipped_names) Line(out, "  skipped", name);
}

std::string OwnImagesText(const OwnImages& own) {
  return std::to_string(own.found) + " of " + std::to_string(own.asked) + " localized";
}

// Whether the map finds its own images, and a warning where it doesn't.
void OwnImagesLines(std::ostream& out, const OwnImages& own) {
  Line(out, "own images", OwnImagesText(own));
  if (own.AreFound()) return;
  Line(out, "warning",
       std::to_string(100 * (own.asked - own.found) / own.asked) +
           " % of the map's own images are not localized at their place: the scene has little "
           "texture or places that look alike; add images or record it more densely");
}

Json OwnImagesJson(const OwnImages& own) { return {{"asked", own.asked}, {"found", own.found}}; }

void AppearanceLines(std::ostream& out, const AppearanceReport& report) {
  FramesLines(out, "panoramas", report,
              ", " + Plural(report.uncertain, "uncertain step") + ", " +
                  std::to_string(report.dropped) + " redundant");
  if (report.IsTrajectoryDoubtful()) {
    Line(out, "warning",
         std::to_string(report.uncertain) + " of " + std::to_string(report.steps) + " steps (" +
             std::to_string(100 * report.uncertain / report.steps) +
             " %) have an uncertain heading: don't rely on the trajectory; record panoramas at "
             "shorter distances");
  }
  Line(out, "loops",
       std::to_string(report.loop_candidates) + " candidates, " +
           std::to_string(report.loops_certain) + " confirmed by the compass, " +
           std::to_string(report.loops_supported) + " by neighbouring matches, " +
           std::to_string(report.loops_rejected) + " rejected by the pose graph");
  OwnImagesLines(out, report.own);
  Line(out, "seconds",
       "decoding " + Seconds(report.decode_s) + ", signatures " + Seconds(report.observe_s) +
           ", odometry " + Seconds(report.odometry_s) + ", loop closure " +
           Seconds(report.loops_s) + ", pose graph " + Seconds(report.graph_s) + ", calibration " +
           Seconds(report.calibrate_s));
}

void OrientationLines(std::ostream& out, const MapData& map, const OrientationReport& report) {
  const OrientationLayer& layer = *map.orientation;
  const bool corridors_known =
      !layer.corridors.empty() || ListSequencesWithUnknownCorridors(map).empty();
  FramesLines(out, "orientation", report,
              ", " + std::to_string(report.unreliable) + " without reliable axes");
  Line(out, "trajectory",
       Plural(TurnCount(layer), "turn") + " in " + Plural(layer.turns.size(), "heading change") +
           ", " + Plural(layer.nodes.size(), "node") + ", " +
           (corridors_known ? Plural(layer.corridors.size(), "corridor")
                            : std::string("corridors unknown (one camera)")) +
           ", " + Plural(LoopCount(layer), "loop"));
  Line(out, "seconds",
       "lines and features " + Seconds(report.observe_s) +
           " (total over threads), axes and turns " + Seconds(report.add_s) + ", edges and loops " +
           Seconds(report.finish_s));
}

std::string PoseNoiseText(const PoseNoiseReport& report) {
  if (report.measured < report.kFewest) {
    return "not measured: too few keyframes (" + std::to_string(report.measured) +
           ") see what others show; covariances of answers come from the query's features only";
  }
  return Digits(report.noise.position_sigma, 3) + " and " +
         Digits(report.noise.rotation_sigma_rad * kDegreesPerRadian, 2) +
         " degrees between keyframes that aren't neighbours, measured on " +
         std::to_string(report.measured) + " of " + std::to_string(report.asked);
}

void PosesLines(std::ostream& out, const PoseReport& report) {
  Line(out, "poses",
       std::to_string(report.posed) + " of " + std::to_string(report.keyframes) + " keyframes, " +
           std::to_string(std::lround(100 * report.consistent)) + " % of their matches agree; " +
           std::to_string(report.placed) + " of " + std::to_string(report.features) +
           " features placed, " + std::to_string(report.contradicting) + " contradict the poses; " +
           Plural(report.planes, "plane") + " fitted");
  Line(out, "pose noise", PoseNoiseText(report.noise));
}

// Lengths are in the unit of the frame.
std::string NodeErrorsText(const std::optional<NodePoseErrors>& errors, int measured) {
  if (!errors) {
    return "not measured: too few panoramas (" + std::to_string(measured) +
           ") are localized in the map without themselves; answers use the program's defaults";
  }
  return "stated position deviations times " + Digits(errors->position_factor, 2) + ", height " +
         Digits(errors->height_sigma, 3) + ", heading " +
         Digits(errors->heading_sigma_rad * kDegreesPerRadian, 2) + " and tilt " +
         Digits(errors->tilt_sigma_rad * kDegreesPerRadian, 2) + " degrees, on " +
         Plural(measured, "panorama");
}

void NodePosesLines(std::ostream& out, const NodePoseReport& report, const MapData& map) {
  std::string text =
      std::to_string(report.posed) + " of " + std::to_string(report.nodes) + " panoramas";
  if (!report.first_without.empty()) text += " (first without: " + report.first_without + ")";
  if (report.posed > 0) {
    text += report.consistent ? ", " + std::to_string(std::lround(100 * *report.consistent)) +
                                    " % of the motions between them agree"
                              : ", not checked against the images: too few share a view or turn";
  }
  Line(out, "poses", text);
  if (report.posed == 0) return;
  Line(out, "errors",
       "with features: " + NodeErrorsText(map.poses->verified_errors, report.measured_by_features));
  Line(out, "",
       "by appearance: " +
           NodeErrorsText(map.poses->appearance_errors, report.measured_by_appearance));
}

Json NodeErrorsJson(const std::optional<NodePoseErrors>& errors, int measured) {
  Json json = {{"measured", measured}};
  if (!errors) return json;
  json["position_factor"] = errors->position_factor;
  json["height_sigma"] = errors->height_sigma;
  json["heading_sigma_deg"] = errors->heading_sigma_rad * kDegreesPerRadian;
  json["tilt_sigma_deg"] = errors->tilt_sigma_rad * kDegreesPerRadian;
  return json;
}

Json NodePosesJson(const NodePoseReport& report, const MapData& map) {
  Json json = {{"nodes", report.nodes}, {"posed", report.posed}};
  json["consistent"] = report.consistent ? Json(*report.consistent) : Json(nullptr);
  if (report.posed == 0) return json;
  json["errors"] = {
      {"features", NodeErrorsJson(map.poses->verified_errors, report.measured_by_features)},
      {"appearance", NodeErrorsJson(map.poses->appearance_errors, report.measured_by_appearance)}};
  return json;
}

Json PoseNoiseJson(const PoseNoiseReport& report) {
  return {{"asked", report.asked},
          {"measured", report.measured},
          {"position_sigma", report.noise.position_sigma},
          {"rotation_sigma_deg", report.noise.rotation_sigma_rad * kDegreesPerRadian}};
}

Json PosesJson(const PoseReport& report) {
  return {{"keyframes", report.keyframes},   {"posed", report.posed},
          {"consistent", report.consistent}, {"features", report.features},
          {"placed", report.placed},         {"contradicting", report.contradicting},
          {"planes", report.planes},         {"noise", PoseNoiseJson(report.noise)},
          {"seconds", report.seconds}};
}

void PlanesLines(std::ostream& out, const PlaneReport& report) {
  FramesLines(
      out, "frames", report,
      ", " + std::to_string(report.stretches) + " stretch" + (report.stretches == 1 ? "" : "es"));
  Line(out, "planes", PlanesText(report));
  if (report.keyframes_linked > 0) {
    Line(out, "revisits",
         std::to_string(report.keyframes_linked) + " keyframes linked to others of the same place");
  }
  OwnImagesLines(out, report.own);
  Line(out, "seconds",
       "decoding " + Seconds(report.decode_s) + ", features " + Seconds(report.observe_s) +
           ", tracking " + Seconds(report.add_s) + ", fusion " + Seconds(report.fusion_s) +
           ", calibration " + Seconds(report.calibrate_s) + " (total over threads)");
}

Json AppearanceReportJson(const AppearanceReport& report) {
  return {{"frames", report.frames},
          {"skipped", report.skipped},
          {"skipped_names", report.skipped_names},
          {"steps", report.steps},
          {"uncertain", report.uncertain},
          {"loop_candidates", report.loop_candidates},
          {"loops_certain", report.loops_certain},
          {"loops_supported", report.loops_supported},
          {"loops_rejected", report.loops_rejected},
          {"dropped", report.dropped},
          {"own_images", OwnImagesJson(report.own)},
          {"seconds",
           {{"decode", Rounded(report.decode_s, 3)},
            {"describe", Rounded(report.observe_s, 3)},
            {"odometry", Rounded(report.odometry_s, 3)},
            {"loops", Rounded(report.loops_s, 3)},
            {"poses", Rounded(report.graph_s, 3)}}}};
}

Json OrientationReportJson(const OrientationReport& report) {
  return {{"frames", report.frames},
          {"unreadable", report.skipped},
          {"unreadable_names", report.skipped_names},
          {"unreliable", report.unreliable},
          {"tests", report.tests},
          {"seconds",
           {{"look", Rounded(report.observe_s, 3)},
            {"follow", Rounded(report.add_s, 3)},
            {"finish", Rounded(report.finish_s, 3)}}}};
}

size_t SurfaceCount(const MapData& map) {
  return static_cast<size_t>(CountSurfaces(FindSurfaces(map.planes, map.edges)));
}

}  // namespace

Json OrientationJson(const MapData& map) {
  if (!map.orientation) return nullptr;
  const OrientationLayer& layer = *map.orientation;
  return {{"frames", layer.frames.size()},
          {"reliable", ReliableCount(layer)},
          {"turns", TurnCount(layer)},
          {"jumps", layer.turns.size()},
          {"nodes", layer.nodes.size()},
          {"edges", layer.edges.size()},
          {"corridors", layer.corridors.size()},
          {"loops", LoopCount(layer)},
          {"step", layer.step}};
}

Json AppearanceJson(const MapData& map) {
  if (!map.appearance) return nullptr;
  const AppearanceLayer& layer = *map.appearance;
  return {{"nodes", layer.nodes.size()},  {"edges", layer.edges.size()},
          {"loops", LoopCount(layer)},    {"dropped", layer.dropped},
          {"rows", layer.described.rows}, {"k1", layer.described.k1},
          {"k2", layer.described.k2},     {"calibrated", layer.verdict.has_value()}};
}

std::string BytesText(uint64_t bytes) {
  static constexpr std::array<const char*, 4> kUnits = {"B", "kB", "MB", "GB"};
  auto value = static_cast<double>(bytes);
  size_t unit = 0;
  while (value >= 1000 && unit + 1 < kUnits.size()) {
    value /= 1000;
    ++unit;
  }
  std::ostringstream text;
  text << std::fixed << std::setprecision(unit == 0 ? 0 : 1) << value << ' ' << kUnits[unit];
  return text.str();
}

std::string CountsText(const MapData& map) {
  std::vector<std::string> parts;
  const size_t landmarks = LandmarkCount(map);
  if (!map.planes.empty() || landmarks > 0 || (!map.appearance && !map.orientation)) {
    parts = {Plural(map.keyframes.size(), "keyframe"), Plural(map.planes.size(), "plane"),
             Plural(SurfaceCount(map), "surface"), Plural(map.edges.size(), "edge"),
             Plural(FeatureCount(map), "feature")};
  }
  if (landmarks > 0) parts.push_back(Plural(landmarks, "landmark"));
  if (map.appearance) {
    parts.push_back(Plural(map.appearance->nodes.size(), "panorama") + " with " +
                    Plural(LoopCount(*map.appearance), "loop"));
  }
  if (map.orientation) {
    parts.push_back(Plural(map.orientation->frames.size(), "orientation frame") + " with " +
                    Plural(TurnCount(*map.orientation), "turn"));
  }
  if (map.poses) {
    parts.push_back(Plural(map.poses->keyframes.size() + map.poses->nodes.size(), "pose"));
  }
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : ", ") + part;
  return text;
}

std::string TablesText(const std::vector<TableSize>& sizes) {
  std::vector<TableSize> sorted = sizes;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const TableSize& a, const TableSize& b) { return a.bytes > b.bytes; });
  std::ostringstream text;
  for (const TableSize& size : sorted) {
    if (size.rows == 0) continue;  // of a layer that the map lacks
    text << "  " << std::left << std::setw(25) << size.table << std::right << std::setw(10)
         << size.rows << " rows" << std::setw(12) << BytesText(static_cast<uint64_t>(size.bytes))
         << '\n';
  }
  return text.str();
}

Json TablesJson(const std::vector<TableSize>& sizes) {
  Json list = Json::array();
  for (const TableSize& size : sizes) {
    list.push_back({{"table", size.table}, {"rows", size.rows}, {"bytes", size.bytes}});
  }
  return list;
}

std::string SummaryText(const BuildSummary& summary) {
  const BuildReport& report = summary.result->report;
  std::ostringstream text;
  text << summary.path << ": " << CountsText(summary.result->map) << ", "
       << BytesText(summary.bytes) << " in " << Seconds(report.total_s) << " s\n";
  if (report.planes) PlanesLines(text, *report.planes);
  if (report.appearance) AppearanceLines(text, *report.appearance);
  if (report.orientation) OrientationLines(text, summary.result->map, *report.orientation);
  if (report.poses) PosesLines(text, *report.poses);
  if (report.node_poses) NodePosesLines(text, *report.node_poses, summary.result->map);
  Line(text, "version", summary.version);
  text << TablesText(summary.tables);
  return text.str();
}

Json SummaryJson(const BuildSummary& summary) {
  const BuildReport& report = summary.result->report;
  const PlaneReport planes = report.planes.value_or(PlaneReport{});
  const MapData& map = summary.result->map;
  Json json;
  json["map"] = summary.path;
  json["version"] = summary.version;
  json["bytes"] = summary.bytes;
  json["keyframes"] = map.keyframes.size();
  json["planes"] = map.planes.size();
  json["surfaces"] = SurfaceCount(map);
  json["edges"] = map.edges.size();
  json["features"] = FeatureCount(map);
  json["landmarks"] = LandmarkCount(map);
  json["frames"] = planes.frames;
  json["skipped"] = planes.skipped;
  json["skipped_names"] = planes.skipped_names;
  json["stretches"] = planes.stretches;
  json["rotation_only"] = planes.rotation_only;
  json["planes_started"] = planes.planes_started;
  json["planes_rejected"] = planes.planes_rejected;
  json["planes_merged"] = planes.planes_merged;
  json["planes_fused"] = planes.planes_fused;
  json["keyframes_linked"] = planes.keyframes_linked;
  json["planes_dropped"] = planes.planes_dropped;
  json["features_dropped"] = planes.features_dropped;
  json["own_images"] = OwnImagesJson(planes.own);
  json["seconds"] = {
      {"decode", Rounded(planes.decode_s, 3)},       {"extract", Rounded(planes.observe_s, 3)},
      {"track", Rounded(planes.add_s, 3)},           {"fusion", Rounded(planes.fusion_s, 3)},
      {"calibrate", Rounded(planes.calibrate_s, 3)}, {"total", Rounded(report.total_s, 3)}};
  json["appearance"] = AppearanceJson(map);
  if (report.appearance) json["appearance"]["report"] = AppearanceReportJson(*report.appearance);
  json["orientation"] = OrientationJson(map);
  if (report.orientation) {
    json["orientation"]["report"] = OrientationReportJson(*report.orientation);
  }
  if (report.poses) json["poses"] = PosesJson(*report.poses);
  if (report.node_poses) json["node_poses"] = NodePosesJson(*report.node_poses, map);
  json["tables"] = TablesJson(summary.tables);
  return json;
}

}  // namespace waystone
