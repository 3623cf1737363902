// SPDX-License-Identifier: Apache-2.0
#include "builder/report/appearance_svg.h"

#include <algorithm>
#include <iomanip>
#include <sstream>
#include <unordered_map>

#include "core/base/text.h"

namespace waystone {
namespace {

// The drawing, in its own units.
constexpr double kPlanWidth = 1200;
constexpr double kPlanMostHeight = 800;
constexpr double kPlanMargin = 20;
constexpr double kLeastExtent = 1e-6;  // of nodes that are all at one place

struct Point {
  double x = 0;
  double y = 0;
};

// From the layer's units to the drawing's.
class PlanFrame {
 public:
  explicit PlanFrame(const AppearanceLayer& layer) {
    const auto [left, right] = std::ranges::minmax(layer.nodes, {}, XOf);
    const auto [bottom, top] = std::ranges::minmax(layer.nodes, {}, YOf);
    left_ = left.pose.x;
    top_ = top.pose.y;
    const double wide = std::max(right.pose.x - left_, kLeastExtent);
    const double high = std::max(top_ - bottom.pose.y, kLeastExtent);
    scale_ =
        std::min((kPlanWidth - 2 * kPlanMargin) / wide, (kPlanMostHeight - 2 * kPlanMargin) / high);
    height_ = 2 * kPlanMargin + scale_ * high;
    margin_ = (kPlanWidth - scale_ * wide) /
              2;  // a trajectory that is higher than wide stands in the middle
  }

  double height() const { return height_; }
  Point At(const Pose2& pose) const {
    return {margin_ + scale_ * (pose.x - left_), kPlanMargin + scale_ * (top_ - pose.y)};
  }

 private:
  static double XOf(const AppearanceNode& node) { return node.pose.x; }
  static double YOf(const AppearanceNode& node) { return node.pose.y; }

  double left_ = 0;
  double top_ = 0;
  double scale_ = 1;
  double height_ = 0;
  double margin_ = kPlanMargin;  // to the left and right
};

void Line(std::ostream& svg, const Point& a, const Point& b, bool loop) {
  svg << "<line x1=" << a.x << " y1=" << a.y << " x2=" << b.x << " y2=" << b.y
      << (loop ? " style=\"stroke:#e08214\"" : "") << " />\n";
}

}  // namespace

std::string AppearanceSvg(const AppearanceLayer& layer) {
  if (layer.nodes.empty()) return "";
  const PlanFrame frame(layer);
  std::unordered_map<AppearanceNodeId, Point> at;
  for (const AppearanceNode& node : layer.nodes) at[node.id] = frame.At(node.pose);
  std::ostringstream svg;
  svg << std::fixed << std::setprecision(1) << "<svg viewBox=\"0 0 " << kPlanWidth << ' '
      << frame.height() << "\" role=img aria-label=\"Trajectory of the panoramas\">\n";
  for (const AppearanceEdge& edge : layer.edges) {
    Line(svg, at[edge.a], at[edge.b], edge.kind == AppearanceEdgeKind::kLoop);
  }
  for (const AppearanceNode& node : layer.nodes) {
    svg << "<circle cx=" << at[node.id].x << " cy=" << at[node.id].y
        << " r=3 fill=\"#2166ac\"><title>" << node.id.value << " " << EscapeHtml(node.source)
        << "</title></circle>\n";
  }
  svg << "</svg>\n";
  return svg.str();
}

}  // namespace waystone
