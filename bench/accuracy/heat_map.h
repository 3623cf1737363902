// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace waystone::bench {

// A table of values over two parameters: rows[r] is the value of the vertical one.
struct HeatPanel {
  std::string title;
  std::vector<int> rows;
  std::vector<int> columns;
  std::vector<std::vector<double>> values;  // [row][column]
};

struct HeatMap {
  std::string title;
  std::string row_label;
  std::string column_label;
  int decimals = 4;               // of the values
  std::vector<HeatPanel> panels;  // side by side, two in a row
};

// The panels as one SVG picture; all share one scale of colours, which is logarithmic, since the
// values span decades. Values are above 0.
std::string HeatMapSvg(const HeatMap& map);

}  // namespace waystone::bench
