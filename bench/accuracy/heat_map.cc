// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/heat_map.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>

namespace waystone::bench {
namespace {

constexpr int kCell_px = 62;
constexpr int kCellHeight_px = 26;
constexpr int kLeft_px = 52;
constexpr int kTop_px = 46;
constexpr int kBetween_px = 34;
constexpr int kHead_px = 34;
constexpr int kPanelsInARow = 2;

struct ValueRange {
  double low = std::numeric_limits<double>::max();
  double high = 0;
};

ValueRange FindValueRange(const HeatMap& map) {
  ValueRange range;
  for (const HeatPanel& panel : map.panels) {
    for (const auto& row : panel.values) {
      for (const double value : row) {
        range.low = std::min(range.low, value);
        range.high = std::max(range.high, value);
      }
    }
  }
  return range;
}

// White for the least, blue for the most.
std::string Colour(double value, const ValueRange& range) {
  const double span = std::log(range.high / range.low);
  const double share = span > 0 ? std::log(value / range.low) / span : 0;
  const auto mix = [&](double from, double to) {
    return std::to_string(static_cast<int>(std::lround(from + share * (to - from))));
  };
  return "rgb(" + mix(247, 66) + "," + mix(251, 146) + "," + mix(255, 198) + ")";
}

void Text(std::ostream& svg, double x, double y, const std::string& text,
          const std::string& anchor = "middle") {
  svg << "<text x=\"" << x << "\" y=\"" << y << "\" text-anchor=\"" << anchor << "\">" << text
      << "</text>\n";
}

void DrawPanel(std::ostream& svg, const HeatMap& map, const HeatPanel& panel,
               const ValueRange& range, double left, double top) {
  Text(svg, left + kLeft_px, top + 14, panel.title, "start");
  Text(svg, left + kLeft_px - 6, top + kTop_px - 6, map.row_label + " \\ " + map.column_label,
       "end");
  for (size_t c = 0; c < panel.columns.size(); ++c) {
    Text(svg, left + kLeft_px + (static_cast<double>(c) + 0.5) * kCell_px, top + kTop_px - 6,
         std::to_string(panel.columns[c]));
  }
  for (size_t r = 0; r < panel.rows.size(); ++r) {
    const double y = top + kTop_px + static_cast<double>(r) * kCellHeight_px;
    Text(svg, left + kLeft_px - 6, y + 17, std::to_string(panel.rows[r]), "end");
    for (size_t c = 0; c < panel.columns.size(); ++c) {
      const double x = left + kLeft_px + static_cast<double>(c) * kCell_px;
      std::ostringstream number;
      number << std::fixed << std::setprecision(map.decimals) << panel.values[r][c];
      svg << "<rect x=\"" << x << "\" y=\"" << y << "\" width=\"" << kCell_px - 1 << "\" height=\""
          << kCellHeight_px - 1 << "\" fill=\"" << Colour(panel.values[r][c], range) << "\"/>\n";
      Text(svg, x + kCell_px / 2.0, y + 17, number.str());
    }
  }
}

}  // namespace

std::string HeatMapSvg(const HeatMap& map) {
  size_t columns = 0;
  size_t rows = 0;
  for (const HeatPanel& panel : map.panels) {
    columns = std::max(columns, panel.columns.size());
    rows = std::max(rows, panel.rows.size());
  }
  const auto wide = static_cast<double>(columns * kCell_px + kLeft_px + kBetween_px);
  const auto high = static_cast<double>(rows * kCellHeight_px + kTop_px + kBetween_px);
  const size_t lines = (map.panels.size() + kPanelsInARow - 1) / kPanelsInARow;
  const ValueRange range = FindValueRange(map);
  std::ostringstream svg;
  svg << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" << kPanelsInARow * wide
      << "\" height=\"" << kHead_px + static_cast<double>(lines) * high
      << "\" font-family=\"sans-serif\" font-size=\"12\">\n"
      << "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
  Text(svg, kLeft_px, 22, map.title, "start");
  for (size_t i = 0; i < map.panels.size(); ++i) {
    const size_t row = i / kPanelsInARow;
    DrawPanel(svg, map, map.panels[i], range, static_cast<double>(i % kPanelsInARow) * wide,
              kHead_px + static_cast<double>(row) * high);
  }
  svg << "</svg>\n";
  return svg.str();
}

}  // namespace waystone::bench
