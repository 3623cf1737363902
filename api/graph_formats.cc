// SPDX-License-Identifier: Apache-2.0
#include "api/graph_formats.h"

#include <optional>
#include <sstream>
#include <string_view>

#include "api/json.h"
#include "api/pose_formats.h"
#include "core/base/error.h"
#include "core/base/text.h"

namespace waystone {
namespace {

// The name of a plane's reference image as UTF-8, without characters that XML can't represent:
// controls, U+FFFE and U+FFFF.
std::string SourceOf(const MapIndex& index, const Plane& plane) {
  const Keyframe* keyframe = index.FindKeyframe(plane.reference);
  std::string text = keyframe ? ToUtf8(keyframe->source) : "";
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < ' ') c = '?';
  }
  for (const std::string_view none : {"\xEF\xBF\xBE", "\xEF\xBF\xBF"}) {
    for (size_t at = text.find(none); at != text.npos; at = text.find(none)) {
      text.replace(at, none.size(), "?");
    }
  }
  return text;
}

std::string Row(const Eigen::Matrix3d& matrix) {
  std::ostringstream out;
  out.exceptions(std::ios::badbit);  // for memory that runs out
  out.precision(17);
  for (int i = 0; i < 9; ++i) out << (i ? " " : "") << matrix(i / 3, i % 3);
  return out.str();
}

std::string GraphMl(const MapIndex& index) {
  std::ostringstream out;
  out.exceptions(std::ios::badbit);  // for memory that runs out
  out << R"(<?xml version="1.0" encoding="UTF-8"?>
<graphml xmlns="http://graphml.graphdrawing.org/xmlns">
<key id="source" for="node" attr.name="source" attr.type="string"/>
<key id="reference" for="node" attr.name="reference" attr.type="long"/>
<key id="features" for="node" attr.name="features" attr.type="int"/>
<key id="views" for="node" attr.name="views" attr.type="int"/>
<key id="surface" for="node" attr.name="surface" attr.type="long"/>
<key id="eigenvalue" for="edge" attr.name="third_eigenvalue" attr.type="double"/>
<key id="homology" for="edge" attr.name="homology" attr.type="string"/>
<graph edgedefault="undirected">
)";
  for (const Plane& plane : index.map().planes) {
    out << "<node id=\"p" << plane.id.value << "\"><data key=\"source\">"
        << EscapeHtml(SourceOf(index, plane)) << "</data><data key=\"reference\">"
        << plane.reference.value << "</data><data key=\"features\">" << plane.features.size()
        << "</data><data key=\"views\">" << plane.views.size() << "</data><data key=\"surface\">"
        << index.SurfaceOf(plane.id).value << "</data></node>\n";
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
  out.exceptions(std::ios::badbit);  // for memory that runs out
  out << "graph waystone {\n";
  for (const Plane& plane : index.map().planes) {
    std::string label;
    for (const char c : SourceOf(index, plane)) {
      if (c == '"' || c == '\\') label += '\\';
      label += c;
    }
    out << "  p" << plane.id.value << " [label=\"" << plane.id.value << "\\n"
        << label << "\", features=" << plane.features.size()
        << ", surface=" << index.SurfaceOf(plane.id).value << "];\n";
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
  for (const std::string& name : PoseFormatNames()) names.push_back(name);
  return names;
}

GraphText FormatGraph(const MapIndex& index, const std::string& format) {
  if (format == "graphml") return {GraphMl(index), "application/xml"};
  if (format == "dot") return {Dot(index), "text/vnd.graphviz"};
  if (std::optional<GraphText> poses = FormatPoses(index.map(), format)) return *poses;
  std::string names = "json";
  for (const std::string& name : GraphFormatNames()) names += ", " + name;
  throw MapError(ErrorCode::kBadRequest, "format '" + Printable(format.substr(0, 40)) +
                                             "' is unknown; supported formats: " + names);
}

}  // namespace waystone
