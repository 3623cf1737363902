// SPDX-License-Identifier: Apache-2.0
#include "builder/report/html.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>
#include <unordered_map>

#include "builder/report/appearance_svg.h"
#include "builder/report/colours.h"
#include "builder/report/graph_layout.h"
#include "builder/report/orientation_svg.h"
#include "builder/report/surface_graph.h"
#include "core/base/text.h"

namespace waystone {
namespace {

constexpr const char* kStyle = R"(
:root { color-scheme: light dark; --line: #8884; --soft: #8881; }
body { font: 15px/1.5 system-ui, sans-serif; max-width: 76rem; margin: 2rem auto; padding: 0 1rem; }
h1 { margin-bottom: 0; } h2 { margin-top: 2.5rem; }
.sub { opacity: .75; margin-top: .2rem; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
td, th { padding: .2rem .8rem .2rem 0; text-align: right; border-bottom: 1px solid var(--line); }
td:first-child, th:first-child { text-align: left; }
.row { display: flex; flex-wrap: wrap; gap: 3rem; align-items: start; }
.gallery { display: grid; grid-template-columns: repeat(auto-fill, minmax(20rem, 1fr)); gap: 1.2rem; }
figure { margin: 0; } figure img { width: 100%; height: auto; border-radius: 6px; display: block; }
figcaption { font-size: .85rem; padding-top: .3rem; }
.chip { display: inline-block; min-width: 1.4em; padding: 0 .35em; border-radius: 1em; text-align: center;
  color: #000; font-size: .8rem; }
svg { width: 100%; height: auto; border: 1px solid var(--line); border-radius: 6px; }
svg line { stroke: #8888; stroke-width: 1.5; } svg text { font: 11px system-ui; text-anchor: middle; fill: #000; }
.plot text, .cells text { fill: currentColor; font-size: 14px; } .plot .tick { text-anchor: end; }
.plot .name { text-anchor: start; } svg.cells text { font-size: 12px; } svg.cells .tick { font-size: 7px; }
.nodes { display: grid; grid-template-columns: repeat(auto-fill, minmax(8rem, 1fr)); gap: 1rem; }
.scroll { max-height: 32rem; overflow: auto; }
)";

// The graph's drawing, in its own units.
constexpr double kGraphWidth = 1200;
constexpr double kGraphHeight = 640;
constexpr double kGraphMargin = 45;
constexpr double kSmallestNode = 9;
// A node's area grows with its features; the largest surface's node has this radius.
constexpr double kLargestNode = 30;

std::string Chip(PlaneId plane, PlaneId surface) {
  return "<span class=chip style=\"background:" + CssColourOf(surface) + "\">" +
         std::to_string(plane.value) + "</span>";
}

template <class A, class B>
std::string Row(const A& label, const B& value) {
  std::ostringstream row;
  row << "<tr><td>" << label << "<td>" << value << '\n';
  return row.str();
}

std::string Fixed(double value, int decimals) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(decimals) << value;
  return text.str();
}

// "3, 8, 12"
std::string IdsText(const std::vector<PlaneId>& ids) {
  std::string text;
  for (const PlaneId id : ids) text += (text.empty() ? "" : ", ") + std::to_string(id.value);
  return text;
}

std::string GraphSvg(const SurfaceGraph& graph) {
  std::vector<Eigen::Vector2d> at = LayOutGraph(graph.surfaces.size(), graph.edges);
  for (Eigen::Vector2d& p : at) {
    p = {kGraphMargin + p.x() * (kGraphWidth - 2 * kGraphMargin),
         kGraphMargin + p.y() * (kGraphHeight - 2 * kGraphMargin)};
  }
  std::ostringstream svg;
  svg << std::fixed << std::setprecision(1) << "<svg viewBox=\"0 0 " << kGraphWidth << ' '
      << kGraphHeight << "\" role=img aria-label=\"Graph of surfaces\">\n";
  for (const auto& [a, b] : graph.edges) {
    svg << "<line x1=" << at[a].x() << " y1=" << at[a].y() << " x2=" << at[b].x()
        << " y2=" << at[b].y() << " />\n";
  }
  size_t most = 1;
  for (const Surface& surface : graph.surfaces) most = std::max(most, surface.features);
  for (size_t i = 0; i < graph.surfaces.size(); ++i) {
    const Surface& surface = graph.surfaces[i];
    const double share =
        std::sqrt(static_cast<double>(surface.features) / static_cast<double>(most));
    svg << "<g><title>surface " << surface.id.value << ": planes " << IdsText(surface.planes)
        << "; " << surface.features << " features</title><circle cx=" << at[i].x()
        << " cy=" << at[i].y() << " r=" << std::max(kSmallestNode, kLargestNode * share)
        << " fill=\"" << CssColourOf(surface.id) << "\" /><text x=" << at[i].x()
        << " y=" << at[i].y() + 4 << ">" << surface.id.value << "</text></g>\n";
  }
  svg << "</svg>\n";
  return svg.str();
}

std::string OwnImagesCell(const OwnImages& own) {
  const std::string text = std::to_string(own.found) + " of " + std::to_string(own.asked);
  return own.AreFound() ? text : "<b>" + text + "</b>";
}

std::string CountsTable(const AppearanceReport& report) {
  return "<table><tr><th>Item<th>Count\n" + Row("frames", report.frames) +
         Row("skipped frames", report.skipped) + Row("uncertain steps", report.uncertain) +
         Row("loop candidates", report.loop_candidates) +
         Row("confirmed by the compass", report.loops_certain) +
         Row("confirmed by neighbouring matches", report.loops_supported) +
         Row("rejected by the pose graph", report.loops_rejected) +
         Row("redundant panoramas", report.dropped) +
         Row("own images found", OwnImagesCell(report.own)) +
         Row("<b>panoramas</b>", report.panoramas - report.dropped) + "</table>\n";
}

std::string SecondsTable(const AppearanceReport& report) {
  return "<table><tr><th>Stage<th>Seconds\n" + Row("decoding", Fixed(report.decode_s, 2)) +
         Row("signatures and features", Fixed(report.observe_s, 2)) +
         Row("odometry", Fixed(report.odometry_s, 2)) +
         Row("loop closure", Fixed(report.loops_s, 2)) +
         Row("pose graph", Fixed(report.graph_s, 2)) +
         Row("calibration", Fixed(report.calibrate_s, 2)) + "</table>\n";
}

std::string CountsTable(const MapData& map, const SurfaceGraph& graph, const PlaneReport& report) {
  size_t features = 0;
  for (const Plane& plane : map.planes) features += plane.features.size();
  return "<table><tr><th>Item<th>Count\n" + Row("frames", report.frames) +
         Row("skipped frames", report.skipped) + Row("keyframes", map.keyframes.size()) +
         Row("stretches", report.stretches) + Row("rotation-only pairs", report.rotation_only) +
         Row("planes created", report.planes_started) +
         Row("planes rejected by the homology test", report.planes_rejected) +
         Row("planes merged by the homology test", report.planes_merged) +
         Row("planes fused", report.planes_fused) + Row("planes dropped", report.planes_dropped) +
         Row("keyframes linked with others of the same place", report.keyframes_linked) +
         Row("<b>planes</b>", map.planes.size()) + Row("<b>surfaces</b>", graph.surfaces.size()) +
         Row("<b>edges</b>", map.edges.size()) + Row("<b>features</b>", features) +
         Row("features dropped", report.features_dropped) +
         Row("own images found", OwnImagesCell(report.own)) + "</table>\n";
}

std::string SecondsTable(const PlaneReport& report, double total_s) {
  return "<table><tr><th>Stage<th>Seconds\n" + Row("decoding", Fixed(report.decode_s, 2)) +
         Row("features", Fixed(report.observe_s, 2)) + Row("tracking", Fixed(report.add_s, 2)) +
         Row("fusion", Fixed(report.fusion_s, 2)) +
         Row("calibration", Fixed(report.calibrate_s, 2)) +
         Row("wall-clock time", Fixed(total_s, 2)) + "</table>\n";
}

std::string BytesTable(const std::vector<TableSize>& tables) {
  std::string html = "<table><tr><th>Table<th>Rows<th>Bytes\n";
  for (const TableSize& table : tables) {
    if (table.rows == 0) continue;  // of a layer that the map doesn't have
    html += "<tr><td>" + EscapeHtml(table.table) + "<td>" + std::to_string(table.rows) + "<td>" +
            std::to_string(table.bytes) + "\n";
  }
  return html + "</table>\n";
}

std::string PlanesTable(const MapData& map, const SurfaceGraph& graph) {
  const auto chip = [&](PlaneId id) { return Chip(id, graph.of_plane.at(id)); };
  std::unordered_map<PlaneId, std::string> neighbours;
  for (const Edge& edge : map.edges) {
    neighbours[edge.a] += chip(edge.b) + " ";
    neighbours[edge.b] += chip(edge.a) + " ";
  }
  std::unordered_map<KeyframeId, std::string> sources;
  for (const Keyframe& keyframe : map.keyframes) sources[keyframe.id] = keyframe.source;
  std::string html =
      "<table><tr><th>Plane<th>Surface<th>Features<th>Keyframes<th>Reference<th>Neighbours\n";
  for (const Plane& plane : map.planes) {
    html += "<tr><td>" + chip(plane.id) + "<td>" +
            std::to_string(graph.of_plane.at(plane.id).value) + "<td>" +
            std::to_string(plane.features.size()) + "<td>" + std::to_string(plane.views.size()) +
            "<td>" + EscapeHtml(sources[plane.reference]) + "<td>" + neighbours[plane.id] + "\n";
  }
  return html + "</table>\n";
}

std::string Gallery(const MapData& map, const SurfaceGraph& graph) {
  std::unordered_map<KeyframeId, std::string> seen;
  for (const Plane& plane : map.planes) {
    for (const PlaneView& view : plane.views) {
      seen[view.keyframe] += Chip(plane.id, graph.of_plane.at(plane.id)) + " ";
    }
  }
  std::string html = "<div class=gallery>\n";
  for (const Keyframe& keyframe : map.keyframes) {
    const std::string name = EscapeHtml(keyframe.source);
    html += "<figure><img loading=lazy src=\"" + ImageName(keyframe.id) + "\" alt=\"" + name +
            " with its planes\"><figcaption>" + std::to_string(keyframe.id.value) + " · " + name +
            " " + seen[keyframe.id] + "</figcaption></figure>\n";
  }
  return html + "</div>\n";
}

bool HasPlanes(const MapData& map) { return !map.keyframes.empty(); }

std::string PlanesSection(const SurfaceGraph& graph) {
  if (graph.surfaces.empty()) return "";
  return "<h2>Graph of surfaces</h2>\n" + GraphSvg(graph) +
         "<p class=sub>Nodes are surfaces, such as a wall: planes of the map that are parts of "
         "one, "
         "each as its own reference image shows it. They are sized by their number of features and "
         "named by their first plane. Edges connect surfaces with planes that were seen together "
         "and whose homology is valid.</p>\n";
}

// What was built of each layer, side by side.
std::string TablesSection(const MapData& map, const SurfaceGraph& graph, const BuildReport& report,
                          const std::vector<TableSize>& tables) {
  std::string html = "<div class=row>\n";
  const auto add = [&](const std::string& title, const std::string& table) {
    html += "<div><h2>" + title + "</h2>\n" + table + "</div>";
  };
  if (HasPlanes(map)) {
    const PlaneReport planes = report.planes.value_or(PlaneReport{});
    add("Counts", CountsTable(map, graph, planes));
    add("Time (s)", SecondsTable(planes, report.total_s));
  }
  if (report.appearance) {
    add("Panoramas", CountsTable(*report.appearance));
    add("Time (s), panoramas", SecondsTable(*report.appearance));
  }
  add("Size", BytesTable(tables));
  return html + "</div>\n";
}

std::string KeyframesSection(const MapData& map, const SurfaceGraph& graph) {
  if (!HasPlanes(map)) return "";
  return "<h2>Keyframes and their planes</h2>\n"
         "<p class=sub>Planes of one surface have one colour in all keyframes.</p>\n" +
         Gallery(map, graph) + "<h2>Planes</h2>\n<div class=scroll>" + PlanesTable(map, graph) +
         "</div>\n";
}

// "12 keyframes, 3 planes on 2 surfaces, 2 edges; 40 panoramas"
std::string Subtitle(const MapData& map, const SurfaceGraph& graph) {
  std::string text;
  if (HasPlanes(map)) {
    text = std::to_string(map.keyframes.size()) + " keyframes, " +
           std::to_string(map.planes.size()) + " planes on " +
           std::to_string(graph.surfaces.size()) + " surfaces, " +
           std::to_string(map.edges.size()) + " edges; ";
  }
  if (map.appearance) text += std::to_string(map.appearance->nodes.size()) + " panoramas; ";
  if (map.orientation) {
    text += std::to_string(map.orientation->frames.size()) + " orientation frames, " +
            std::to_string(
                std::ranges::count(map.orientation->turns, true, &OrientationTurn::confirmed)) +
            " turns; ";
  }
  return text;
}

std::string AppearanceSection(const MapData& map) {
  if (!map.appearance) return "";
  const AppearanceLayer& layer = *map.appearance;
  return "<h2>Trajectory of the panoramas</h2>\n" + AppearanceSvg(layer) + "<p class=sub>" +
         std::to_string(layer.nodes.size()) + " panoramas, " + std::to_string(layer.dropped) +
         " redundant ones dropped. Dots are panoramas, lines connect consecutive ones, and orange "
         "lines are loop closures.</p>\n";
}

// The traversable directions at the nodes of a sequence.
std::string CellsGallery(const OrientationLayer& layer, SequenceId sequence) {
  std::unordered_map<OrientationFrameId, const OrientationFrame*> frames;
  for (const OrientationFrame& frame : layer.frames) {
    if (frame.sequence == sequence) frames[frame.id] = &frame;
  }
  std::string html = "<div class=nodes>\n";
  for (const OrientationNode& node : layer.nodes) {
    const auto it = frames.find(node.frame);
    if (it == frames.end() || !it->second->reliable) continue;  // nothing was counted
    html += "<figure>" + DirectionCellsSvg(node) + "<figcaption>" + EscapeHtml(it->second->source) +
            (node.kind == OrientationNodeKind::kTurn ? ", turn" : "") + "</figcaption></figure>\n";
  }
  return html + "</div>\n";
}

std::string OrientationSection(const MapData& map) {
  if (!map.orientation) return "";
  const OrientationLayer& layer = *map.orientation;
  const std::vector<SequenceId> sequences = SequencesOf(layer);
  std::string html;
  for (size_t i = 0; i < sequences.size(); ++i) {
    const std::string number = sequences.size() > 1 ? ", sequence " + std::to_string(i + 1) : "";
    html +=
        "<h2>Trajectory by turns" + number + "</h2>\n" + OrientationMapSvg(layer, sequences[i]) +
        "<p class=sub>Red: turn. Green: view break. Blue: camera-only turn. Orange: loop "
        "closure. Shaded: corridor. Strokes show the heading. Drawn from headings alone with "
        "one step per frame, so loops need not close.</p>\n<div class=plot>" +
        OrientationPlotSvg(layer, sequences[i]) +
        "</div><p class=sub>Top: heading, 0 along the map's x and 90 along its y; grey where "
        "not reliable. Bottom: lines along x (red), y (green) and z (blue, vertical). Vertical "
        "marks are turns, blue ones camera-only; corridors are shaded.</p>\n"
        "<h2>Traversable directions" +
        number + "</h2>\n" + CellsGallery(layer, sequences[i]) +
        "<p class=sub>Lines perpendicular to the direction of travel in the upper, right, lower "
        "and left cell of the image. Many lines mean that the direction is open. Nodes with a "
        "reliable rotation only.</p>\n";
  }
  return html;
}

}  // namespace

std::string ImageName(KeyframeId id) { return "images/" + std::to_string(id.value) + ".jpg"; }

std::string ReportHtml(const MapData& map, const BuildReport& report,
                       const std::vector<TableSize>& tables) {
  const std::string name = EscapeHtml(map.info.name);
  const SurfaceGraph graph = SurfacesOf(map);
  return std::string(kReportStart) +
         "<meta name=viewport content=\"width=device-width\">\n<title>" + name +
         " - Waystone map</title>\n<style>" + kStyle + "</style>\n<h1>" + name +
         "</h1>\n<p class=sub>" + Subtitle(map, graph) + "built by " +
         EscapeHtml(map.info.program) + "</p>\n" + AppearanceSection(map) +
         OrientationSection(map) + PlanesSection(graph) +
         TablesSection(map, graph, report, tables) + KeyframesSection(map, graph) + "</html>\n";
}

}  // namespace waystone
