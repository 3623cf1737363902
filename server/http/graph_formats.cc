// SPDX-License-Identifier: Apache-2.0
#include "server/http/graph_formats.h"

#include <sstream>

#include "core/base/error.h"
#include "core/base/text.h"
#include "server/http/json.h"

namespace waystone {
namespace {

// What a format shows that needs poses.
struct PoseFormat {
  const char* name;
  const char* what;
};
constexpr PoseFormat kPoseFormats[] = {
    {"g2o", "a g2o graph has a metric pose at each node"},
    {"geojson", "GeoJSON has positions on the earth"},
    {"ply", "a PLY cloud has points in metric space"},
    {"tum", "a TUM trajectory has a metric pose at each time"},
    {"colmap", "a COLMAP model has the poses of cameras and points"},
    {"poses", "lines of visuallocalization.net have camera poses"},
};

// The name of a plane's reference image, without characters that XML has no way to write.
std::string SourceOf(const MapIndex& index, const Plane& plane) {
  const Keyframe* keyframe = index.FindKeyframe(plane.reference);
  std::string text;
  for (const char c : keyframe ? keyframe->source : "") {
    text += static_cast<unsigned char>(c) < ' ' ? '?' : c;
  }
  return text;
}

std::string Row(const Eigen::Matrix3d& matrix) {
  std::ostringstream out;
  out.precision(17);
  for (int i = 0; i < 9; ++i) out << (i ? " " : "") << matrix(i / 3, i % 3);
  return out.str();
}

std::string GraphMl(const MapIndex& index) {
  std::ostringstream out;
  out << R"(<?xml version="1.0" encoding="UTF-8"?>
<graphml xmlns="http://graphml.graphdrawing.org/xmlns">
<key id="source" for="node" attr.name="source" attr.type="string"/>
<key id="reference" for="node" attr.name="reference" attr.type="long"/>
<key id="features" for="node" attr.name="features" attr.type="int"/>
<key id="views" for="node" attr.name="views" attr.type="int"/>
<key id="eigenvalue" for="edge" attr.name="third_eigenvalue" attr.type="double"/>
<key id="homology" for="edge" attr.name="homology" attr.type="string"/>
<graph edgedefault="undirected">
)";
  for (const Plane& plane : index.map().planes) {
    out << "<node id=\"p" << plane.id.value << "\"><data key=\"source\">"
        << EscapeHtml(SourceOf(index, plane)) << "</data><data key=\"reference\">"
        << plane.reference.value << "</data><data key=\"features\">" << plane.features.size()
        << "</data><data key=\"views\">" << plane.views.size() << "</data></node>\n";
  }
  out.precision(17);
  for (const Edge& edge : index.map().edges) {
    out << "<edge source=\"p" << edge.a.value << "\" target=\"p" << edge.b.value
        << "\"><data key=\"eigenvalue\">" << edge.third_eigenvalue
        << "</data><data key=\"homology\">" << Row(edge.homology) << "</data></edge>\n";
  }
  out << "</graph>\n</graphml>\n";
  return out.str();
}

std::string Dot(const MapIndex& index) {
  std::ostringstream out;
  out << "graph waystone {\n";
  for (const Plane& plane : index.map().planes) {
    std::string label;
    for (const char c : SourceOf(index, plane)) {
      if (c == '"' || c == '\\') label += '\\';
      label += c;
    }
    out << "  p" << plane.id.value << " [label=\"" << plane.id.value << "\\n"
        << label << "\", features=" << plane.features.size() << "];\n";
  }
  for (const Edge& edge : index.map().edges) {
    out << "  p" << edge.a.value << " -- p" << edge.b.value << ";\n";
  }
  out << "}\n";
  return out.str();
}

}  // namespace

std::vector<std::string> GraphFormatNames() {
  std::vector<std::string> names = {"graphml", "dot"};
  for (const PoseFormat& format : kPoseFormats) names.emplace_back(format.name);
  return names;
}

GraphText FormatGraph(const MapIndex& index, const std::string& format) {
  if (format == "graphml") return {GraphMl(index), "application/xml"};
  if (format == "dot") return {Dot(index), "text/vnd.graphviz"};
  for (const PoseFormat& poses : kPoseFormats) {
    if (format != poses.name) continue;
    throw MapError(ErrorCode::kNotAvailable,
                   std::string(poses.what) +
                       ", and this map has homographies between images only; take graphml or dot");
  }
  throw MapError(ErrorCode::kBadRequest,
                 "format '" + format.substr(0, 40) + "' isn't known; take json, graphml or dot");
}

}  // namespace waystone
