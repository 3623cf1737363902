// SPDX-License-Identifier: Apache-2.0
#include "builder/report/orientation_svg.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <numbers>
#include <optional>
#include <sstream>
#include <unordered_map>

#include "builder/orientation/follow.h"
#include "core/base/text.h"
#include "schema/layers/orientation/orientation_trajectory.h"

namespace waystone {
namespace {

// Drawings, in their own units.
constexpr double kWidth = 1200;
constexpr double kMostHeight = 520;
constexpr double kMargin = 40;
constexpr double kTick = 18;  // of a node's heading
// Of the plots: room for the numbers of the axes, and the two panels' heights.
constexpr double kLeft = 60;
constexpr double kHeadingHeight = 170;
constexpr double kLinesHeight = 130;
constexpr double kPanelGap = 40;

constexpr const char* kRed = "#d6454f";
constexpr const char* kGreen = "#2b9348";
constexpr const char* kBlue = "#3a78d8";
constexpr const char* kOrange = "#e08214";
constexpr const char* kShade = "#e0821433";

// Rows of a layer's frames, last included.
struct Rows {
  size_t first = 0;
  size_t last = 0;
};

Rows CollectRows(const OrientationLayer& layer, SequenceId sequence) {
  const auto begin = std::ranges::find(layer.frames, sequence, &OrientationFrame::sequence);
  const auto frames = std::ranges::count(layer.frames, sequence, &OrientationFrame::sequence);
  const auto first = static_cast<size_t>(begin - layer.frames.begin());
  return {first, first + static_cast<size_t>(frames) - 1};
}

std::ostringstream Svg(double height, const std::string& label) {
  std::ostringstream svg;
  svg << std::fixed << std::setprecision(1) << "<svg viewBox=\"0 0 " << kWidth << ' ' << height
      << "\" role=img aria-label=\"" << label << "\">\n";
  return svg;
}

void Line(std::ostream& svg, const Eigen::Vector2d& a, const Eigen::Vector2d& b, const char* colour,
          double width) {
  svg << "<line x1=" << a.x() << " y1=" << a.y() << " x2=" << b.x() << " y2=" << b.y()
      << " style=\"stroke:" << colour << ";stroke-width:" << width << "\" />\n";
}

// A polyline through points that are pushed one by one.
class Curve {
 public:
  Curve(std::ostream& svg, const char* colour, double width) : svg_(svg) {
    svg_ << "<polyline fill=none stroke=\"" << colour << "\" stroke-width=" << width
         << " stroke-linejoin=round stroke-linecap=round points=\"";
  }
  void To(const Eigen::Vector2d& point) { svg_ << point.x() << ',' << point.y() << ' '; }
  ~Curve() { svg_ << "\" />\n"; }
  Curve(const Curve&) = delete;
  Curve& operator=(const Curve&) = delete;

 private:
  std::ostream& svg_;
};

// The trajectory of a sequence in the drawing, y up.
class DrawnTrajectory {
 public:
  DrawnTrajectory(const OrientationLayer& layer, const Rows& rows) : rows_(rows) {
    const std::vector<Eigen::Vector2d> trajectory = ComputeTrajectory(layer);
    Eigen::Vector2d low = trajectory[rows.first];
    Eigen::Vector2d high = low;
    for (size_t i = rows.first; i <= rows.last; ++i) {
      low = low.cwiseMin(trajectory[i]);
      high = high.cwiseMax(trajectory[i]);
    }
    const Eigen::Vector2d size = (high - low).cwiseMax(1);
    const double scale =
        std::min((kWidth - 2 * kMargin) / size.x(), (kMostHeight - 2 * kMargin) / size.y());
    height_ = scale * (high.y() - low.y()) + 2 * kMargin;
    const double left = (kWidth - scale * (high.x() - low.x())) / 2;
    for (size_t i = rows.first; i <= rows.last; ++i) {
      points_.emplace_back(left + scale * (trajectory[i].x() - low.x()),
                           kMargin + scale * (high.y() - trajectory[i].y()));
      row_[layer.frames[i].id] = i;
    }
  }

  double height() const { return height_; }
  bool Has(OrientationFrameId id) const { return row_.contains(id); }
  const Eigen::Vector2d& At(OrientationFrameId id) const { return AtRow(row_.at(id)); }
  const Eigen::Vector2d& AtRow(size_t row) const { return points_[row - rows_.first]; }
  void Draw(std::ostream& svg, size_t first, size_t last, const char* colour, double width) const {
    Curve curve(svg, colour, width);
    for (size_t i = first; i <= last; ++i) curve.To(AtRow(i));
  }
  void Draw(std::ostream& svg, const Corridor& corridor) const {
    Draw(svg, row_.at(corridor.first), row_.at(corridor.last), kShade, 18);
  }
  size_t RowOf(OrientationFrameId id) const { return row_.at(id); }

 private:
  Rows rows_;
  double height_ = 0;
  std::vector<Eigen::Vector2d> points_;
  std::unordered_map<OrientationFrameId, size_t> row_;
};

void Circle(std::ostream& svg, const Eigen::Vector2d& at, double radius, const std::string& paint,
            const std::string& title) {
  svg << "<circle cx=" << at.x() << " cy=" << at.y() << " r=" << radius << ' ' << paint
      << "><title>" << EscapeHtml(title) << "</title></circle>\n";
}

void DrawNode(std::ostream& svg, const DrawnTrajectory& trajectory, const OrientationLayer& layer,
              const OrientationNode& node) {
  const OrientationFrame& frame = layer.frames[trajectory.RowOf(node.frame)];
  const Eigen::Vector2d& at = trajectory.At(node.frame);
  if (const std::optional<double> heading = HeadingOf(frame)) {
    Line(svg, at, at + kTick * Eigen::Vector2d(std::cos(*heading), -std::sin(*heading)),
         "currentColor", 2);
  }
  const bool turn = node.kind == OrientationNodeKind::kTurn;
  Circle(svg, at, turn ? 8 : 6, std::string("fill=\"") + (turn ? kRed : kGreen) + "\"",
         std::string(turn ? "turn: " : "node: ") + frame.source);
}

// A panel of a plot: frames to the right, values up.
struct Panel {
  double top = 0;
  double height = 0;
  double low = 0;
  double high = 1;
  double first = 0;  // frame at the left border
  double last = 1;

  double X(double frame) const {
    return kLeft + (kWidth - kLeft - kMargin) * (frame - first) / std::max(1.0, last - first);
  }
  double Y(double value) const { return top + height * (high - value) / (high - low); }
};

// What both panels show: corridors, turns and the values' axis.
void DrawGround(std::ostream& svg, const Panel& panel, const OrientationLayer& layer,
                const DrawnTrajectory& trajectory, const std::vector<double>& ticks) {
  const auto frame_of = [&](OrientationFrameId id) {
    return static_cast<double>(layer.frames[trajectory.RowOf(id)].frame);
  };
  for (const Corridor& corridor : layer.corridors) {
    if (!trajectory.Has(corridor.first)) continue;
    const double left = panel.X(frame_of(corridor.first));
    svg << "<rect x=" << left << " y=" << panel.top
        << " width=" << panel.X(frame_of(corridor.last)) - left << " height=" << panel.height
        << " fill=\"" << kShade << "\" />\n";
  }
  for (const double tick : ticks) {
    Line(svg, {kLeft, panel.Y(tick)}, {kWidth - kMargin, panel.Y(tick)}, "#8884", 1);
    svg << "<text class=tick x=" << kLeft - 8 << " y=" << panel.Y(tick) + 4 << '>'
        << std::lround(tick) << "</text>\n";
  }
  for (const OrientationTurn& turn : layer.turns) {
    if (!trajectory.Has(turn.frame)) continue;
    const double x = panel.X(frame_of(turn.frame));
    Line(svg, {x, panel.top}, {x, panel.top + panel.height}, turn.confirmed ? kRed : kBlue, 2);
  }
}

void DrawHeadings(std::ostream& svg, const Panel& panel, const OrientationLayer& layer,
                  const Rows& rows) {
  for (size_t i = rows.first; i <= rows.last; ++i) {
    const OrientationFrame& frame = layer.frames[i];
    const std::optional<double> heading = HeadingOf(frame);
    if (!heading) continue;
    svg << "<circle cx=" << panel.X(frame.frame)
        << " cy=" << panel.Y(*heading * 180 / std::numbers::pi) << " r=2.5 fill=\""
        << (frame.reliable ? "currentColor" : "#8888") << "\" />\n";
  }
}

void DrawLineCounts(std::ostream& svg, const Panel& panel, const OrientationLayer& layer,
                    const Rows& rows) {
  const char* const colours[] = {kRed, kGreen, kBlue};
  for (size_t axis = 0; axis < 3; ++axis) {
    Curve curve(svg, colours[axis], 1.5);
    for (size_t i = rows.first; i <= rows.last; ++i) {
      curve.To({panel.X(layer.frames[i].frame), panel.Y(layer.frames[i].lines[axis])});
    }
  }
}

int MostLines(const OrientationLayer& layer, const Rows& rows) {
  int most = 1;
  for (size_t i = rows.first; i <= rows.last; ++i) {
    most = std::max(most, std::ranges::max(layer.frames[i].lines));
  }
  return most;
}

}  // namespace

std::vector<SequenceId> SequencesOf(const OrientationLayer& layer) {
  std::vector<SequenceId> sequences;
  for (const OrientationFrame& frame : layer.frames) {
    if (sequences.empty() || sequences.back() != frame.sequence) {
      sequences.push_back(frame.sequence);
    }
  }
  return sequences;
}

std::string OrientationMapSvg(const OrientationLayer& layer, SequenceId sequence) {
  const Rows rows = CollectRows(layer, sequence);
  const DrawnTrajectory trajectory(layer, rows);
  std::ostringstream svg = Svg(trajectory.height(), "Trajectory by turns");
  for (const Corridor& corridor : layer.corridors) {
    if (trajectory.Has(corridor.first)) trajectory.Draw(svg, corridor);
  }
  trajectory.Draw(svg, rows.first, rows.last, "#8888", 2);
  for (const OrientationEdge& edge : layer.edges) {
    if (edge.kind != OrientationEdgeKind::kLoop || !trajectory.Has(edge.a) ||
        !trajectory.Has(edge.b))
      continue;
    Line(svg, trajectory.At(edge.a), trajectory.At(edge.b), kOrange, 2);
  }
  for (const OrientationNode& node : layer.nodes) {
    if (trajectory.Has(node.frame)) DrawNode(svg, trajectory, layer, node);
  }
  for (const OrientationTurn& turn : layer.turns) {
    if (turn.confirmed || !trajectory.Has(turn.frame)) continue;
    Circle(svg, trajectory.At(turn.frame), 8,
           std::string("fill=none stroke=\"") + kBlue + "\" stroke-width=4",
           "camera-only turn: " + layer.frames[trajectory.RowOf(turn.frame)].source);
  }
  svg << "</svg>\n";
  return svg.str();
}

std::string OrientationPlotSvg(const OrientationLayer& layer, SequenceId sequence) {
  const Rows rows = CollectRows(layer, sequence);
  const DrawnTrajectory trajectory(layer, rows);
  const double first = layer.frames[rows.first].frame;
  const double last = layer.frames[rows.last].frame;
  const Panel headings{20, kHeadingHeight, -185, 185, first, last};
  const double most = MostLines(layer, rows);
  const Panel lines{20 + kHeadingHeight + kPanelGap, kLinesHeight, 0, most, first, last};
  std::ostringstream svg = Svg(lines.top + kLinesHeight + 40, "Heading and lines by frame");
  DrawGround(svg, headings, layer, trajectory, {-180, -90, 0, 90, 180});
  DrawHeadings(svg, headings, layer, rows);
  DrawGround(svg, lines, layer, trajectory, {0, std::floor(most / 2), most});
  DrawLineCounts(svg, lines, layer, rows);
  const double bottom = lines.top + kLinesHeight + 25;
  svg << "<text x=" << kLeft << " y=" << bottom << '>' << std::lround(first)
      << "</text><text x=" << kWidth - kMargin << " y=" << bottom << '>' << std::lround(last)
      << "</text><text x=" << (kLeft + kWidth - kMargin) / 2 << " y=" << bottom << ">frame</text>\n"
      << "<text class=name x=" << kLeft
      << " y=12>heading (degrees)</text><text class=name x=" << kLeft << " y=" << lines.top - 8
      << ">lines</text>\n</svg>\n";
  return svg.str();
}

std::string DirectionCellsSvg(const OrientationNode& node) {
  const char* const names[] = {"up", "right", "down", "left"};
  const char* const points[] = {"0,0 100,0 50,50", "100,0 100,100 50,50", "0,100 100,100 50,50",
                                "0,0 0,100 50,50"};
  const int at[][2] = {{50, 22}, {80, 52}, {50, 86}, {20, 52}};
  const int most = std::max(1, std::ranges::max(node.directions));
  std::ostringstream svg;
  svg << std::fixed << std::setprecision(2)
      << "<svg class=cells viewBox=\"-1 -1 102 102\" role=img aria-label=\"Lines across the "
         "direction of travel\">";
  for (size_t cell = 0; cell < 4; ++cell) {
    svg << "<polygon points=\"" << points[cell] << "\" fill=\"" << kGreen
        << "\" fill-opacity=" << 0.75 * node.directions[cell] / most
        << " stroke=\"#8888\" stroke-width=\"0.8\" /><text x=" << at[cell][0]
        << " y=" << at[cell][1] << '>' << node.directions[cell]
        << "</text><text class=tick x=" << at[cell][0] << " y=" << at[cell][1] + 8 << '>'
        << names[cell] << "</text>";
  }
  svg << "</svg>\n";
  return svg.str();
}

}  // namespace waystone
