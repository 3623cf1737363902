// SPDX-License-Identifier: Apache-2.0
#include "cli/output/trajectory_plot.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "core/base/text.h"

namespace waystone {
namespace {

constexpr double kWidth = 700;  // px, of the drawing without its margins
constexpr double kMargin = 60;
constexpr double kTop = 60;  // title
constexpr double kLegendLine = 24;
constexpr double kMaxHeight = 700;
constexpr int kGridLines = 8;  // about

Eigen::AlignedBox2d BoxOf(const std::vector<PlotLine>& lines) {
  Eigen::AlignedBox2d box;
  for (const PlotLine& line : lines) {
    for (const Eigen::Vector2d& point : line.points) box.extend(point);
  }
  // A trajectory along one axis must have a picture, too.
  const double side = std::max(box.sizes().maxCoeff(), 1e-9);
  const Eigen::Vector2d margin = (0.25 * side - 0.5 * box.sizes().array()).max(0.05 * side);
  return {box.min() - margin, box.max() + margin};
}

// 1, 2 or 5 times a power of ten.
double RoundStep(double step) {
  const double power = std::pow(10, std::floor(std::log10(step)));
  for (const double digit : {1.0, 2.0, 5.0}) {
    if (digit * power >= step) return digit * power;
  }
  return 10 * power;
}

std::vector<double> Multiples(double step, double from, double to) {
  std::vector<double> multiples;
  const double first = std::ceil(from / step);
  const double last = std::floor(to / step);
  for (int i = 0; first + i <= last; ++i) multiples.push_back((first + i) * step);
  return multiples;
}

class Plot {
 public:
  explicit Plot(const Eigen::AlignedBox2d& box)
      : box_(box),
        px_per_m_(std::min(kWidth / box.sizes().x(), kMaxHeight / box.sizes().y())),
        width_(box.sizes().x() * px_per_m_),
        height_(box.sizes().y() * px_per_m_) {}

  std::string Svg(const std::string& title, const std::vector<PlotLine>& lines) {
    const double legend = kLegendLine * static_cast<double>(lines.size());
    const double bottom = kTop + height_ + kMargin;
    svg_ << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" << width_ + 2 * kMargin
         << "\" height=\"" << bottom + legend << "\" font-family=\"sans-serif\" font-size=\"15\">\n"
         << "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
         << "<text x=\"" << kMargin << "\" y=\"35\" font-size=\"19\">" << EscapeHtml(title)
         << "</text>\n";
    DrawGrid();
    double y = bottom;
    for (const PlotLine& line : lines) {
      DrawLine(line);
      DrawLegend(line, y);
      y += kLegendLine;
    }
    svg_ << "</svg>\n";
    return svg_.str();
  }

 private:
  double X(double x) const { return kMargin + (x - box_.min().x()) * px_per_m_; }
  double Y(double y) const { return kTop + (box_.max().y() - y) * px_per_m_; }

  void Segment(double x1, double y1, double x2, double y2) {
    svg_ << "<line x1=\"" << x1 << "\" y1=\"" << y1 << "\" x2=\"" << x2 << "\" y2=\"" << y2
         << "\" stroke=\"#ddd\"/>\n";
  }

  void DrawGrid() {
    const double step = RoundStep(box_.sizes().maxCoeff() / kGridLines);
    for (const double x : Multiples(step, box_.min().x(), box_.max().x())) {
      Segment(X(x), kTop, X(x), kTop + height_);
      svg_ << "<text x=\"" << X(x) << "\" y=\"" << kTop + height_ + 20
           << "\" text-anchor=\"middle\" fill=\"#555\">" << x << "</text>\n";
    }
    for (const double y : Multiples(step, box_.min().y(), box_.max().y())) {
      Segment(kMargin, Y(y), kMargin + width_, Y(y));
      svg_ << "<text x=\"" << kMargin - 8 << "\" y=\"" << Y(y) + 5
           << "\" text-anchor=\"end\" fill=\"#555\">" << y << "</text>\n";
    }
    svg_ << "<text x=\"" << kMargin + width_ << "\" y=\"" << kTop + height_ + 40
         << "\" text-anchor=\"end\" fill=\"#555\">metres; dots mark the start</text>\n";
  }

  void DrawLine(const PlotLine& line) {
    svg_ << "<polyline fill=\"none\" stroke-width=\"2.5\" stroke-linejoin=\"round\" stroke=\""
         << line.colour << "\" points=\"";
    for (const Eigen::Vector2d& p : line.points) svg_ << X(p.x()) << ',' << Y(p.y()) << ' ';
    const Eigen::Vector2d& start = line.points.front();
    svg_ << "\"/>\n<circle r=\"6\" cx=\"" << X(start.x()) << "\" cy=\"" << Y(start.y())
         << "\" fill=\"" << line.colour << "\"/>\n";
  }

  void DrawLegend(const PlotLine& line, double y) {
    svg_ << "<line x1=\"" << kMargin << "\" y1=\"" << y - 5 << "\" x2=\"" << kMargin + 36
         << "\" y2=\"" << y - 5 << "\" stroke-width=\"4\" stroke=\"" << line.colour << "\"/>\n"
         << "<text x=\"" << kMargin + 46 << "\" y=\"" << y << "\">" << EscapeHtml(line.label)
         << "</text>\n";
  }

  Eigen::AlignedBox2d box_;
  double px_per_m_;
  double width_;
  double height_;
  std::ostringstream svg_;
};

}  // namespace

std::string PlotTrajectories(const std::string& title, const std::vector<PlotLine>& lines) {
  return Plot(BoxOf(lines)).Svg(title, lines);
}

}  // namespace waystone
