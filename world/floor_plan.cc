// SPDX-License-Identifier: Apache-2.0
#include "world/floor_plan.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace waystone {
namespace {

constexpr size_t kMaxCells = 1000;  // a side; more would not fit the textures in memory

[[noreturn]] void FailAt(size_t row, size_t column, const std::string& cause) {
  throw MapError(ErrorCode::kBadOptions, "floor plan, line " + std::to_string(row + 1) +
                                             ", column " + std::to_string(column + 1) + ": " +
                                             cause);
}

bool IsWallMark(char mark) { return mark == '#' || (mark >= 'a' && mark <= 'z'); }
bool IsStopMark(char mark) { return mark >= '1' && mark <= '9'; }
bool IsOpenMark(char mark) { return mark == '.' || mark == ' ' || mark == 'D' || IsStopMark(mark); }

// Lines are numbered as typed, so leading empty lines stay until the errors have been looked for.
std::vector<std::string> SplitLines(std::string_view text) {
  std::vector<std::string> lines(1);
  for (const char c : text) {
    if (c == '\n') {
      lines.emplace_back();
    } else if (c != '\r') {
      lines.back().push_back(c);
    }
  }
  return lines;
}

bool IsBlank(const std::string& line) { return line.find_first_not_of(' ') == std::string::npos; }

void CheckMarks(const std::vector<std::string>& lines) {
  for (size_t row = 0; row < lines.size(); ++row) {
    for (size_t column = 0; column < lines[row].size(); ++column) {
      const char mark = lines[row][column];
      if (IsWallMark(mark) || IsOpenMark(mark)) continue;
      FailAt(row, column,
             "unknown mark (code " + std::to_string(static_cast<unsigned char>(mark)) +
                 "); use # . D, a-z for posters, 1-9 for stops");
    }
  }
}

void CheckEdges(const std::vector<std::string>& lines, size_t first, size_t last, size_t columns) {
  for (size_t row = first; row <= last; ++row) {
    for (size_t column = 0; column < lines[row].size(); ++column) {
      const bool edge = row == first || row == last || column == 0 || column + 1 == columns;
      if (edge && IsOpenMark(lines[row][column])) {
        FailAt(row, column, "floor at the plan's edge; close the building with #");
      }
    }
  }
}

std::vector<Eigen::Vector2i> FindStops(const std::vector<std::string>& lines, size_t first) {
  std::vector<std::vector<Eigen::Vector2i>> found(9);
  for (size_t row = first; row < lines.size(); ++row) {
    for (size_t column = 0; column < lines[row].size(); ++column) {
      const char mark = lines[row][column];
      if (!IsStopMark(mark)) continue;
      auto& cells = found[static_cast<size_t>(mark - '1')];
      if (!cells.empty()) FailAt(row, column, std::string("stop ") + mark + " is there twice");
      cells.emplace_back(static_cast<int>(column), static_cast<int>(row - first));
    }
  }
  std::vector<Eigen::Vector2i> stops;
  for (size_t i = 0; i < found.size(); ++i) {
    if (found[i].empty()) continue;
    if (stops.size() != i) {
      FailAt(first + static_cast<size_t>(found[i][0].y()), static_cast<size_t>(found[i][0].x()),
             "stop " + std::to_string(i + 1) + " but no stop " + std::to_string(stops.size() + 1) +
                 "; number the stops from 1 without gaps");
    }
    stops.push_back(found[i][0]);
  }
  return stops;
}

}  // namespace

void PlanOptions::Check() const {
  CheckFields("plan", *this);
  if (door_height_m > wall_height_m) {
    throw MapError(ErrorCode::kBadOptions,
                   "plan.door_height_m is " + std::to_string(door_height_m) +
                       "; it must be at most plan.wall_height_m, " + std::to_string(wall_height_m));
  }
}

bool FloorPlan::IsOpen(int column, int row) const {
  if (column < 0 || row < 0 || column >= columns || row >= rows) return false;
  return IsOpenMark(lines[static_cast<size_t>(row)][static_cast<size_t>(column)]);
}

bool FloorPlan::IsDoor(int column, int row) const {
  return IsOpen(column, row) && lines[static_cast<size_t>(row)][static_cast<size_t>(column)] == 'D';
}

char FloorPlan::PosterAt(int column, int row) const {
  if (column < 0 || row < 0 || column >= columns || row >= rows) return 0;
  const char mark = lines[static_cast<size_t>(row)][static_cast<size_t>(column)];
  return mark >= 'a' && mark <= 'z' ? mark : '\0';
}

Eigen::Vector2d FloorPlan::CentreOf(const Eigen::Vector2i& cell) const {
  return size.cell_m * Eigen::Vector2d(cell.x() + 0.5, rows - cell.y() - 0.5);
}

bool FloorPlan::IsFree(const Eigen::Vector2d& point, double clearance_m) const {
  const auto cell = [this](double metres) {
    return static_cast<int>(std::floor(metres / size.cell_m));
  };
  for (int y = cell(point.y() - clearance_m); y <= cell(point.y() + clearance_m); ++y) {
    for (int x = cell(point.x() - clearance_m); x <= cell(point.x() + clearance_m); ++x) {
      if (!IsOpen(x, rows - 1 - y)) return false;
    }
  }
  return true;
}

std::string FloorPlan::Text() const {
  std::string text;
  for (const std::string& line : lines) text += line + '\n';
  return text;
}

FloorPlan ParseFloorPlan(std::string_view text, const PlanOptions& size) {
  size.Check();
  std::vector<std::string> lines = SplitLines(text);
  while (!lines.empty() && IsBlank(lines.back())) lines.pop_back();
  size_t first = 0;
  while (first < lines.size() && IsBlank(lines[first])) ++first;
  size_t columns = 0;
  for (const std::string& line : lines) columns = std::max(columns, line.size());
  if (lines.size() > kMaxCells || columns > kMaxCells) {
    FailAt(lines.size() - 1, columns, "more than 1000 lines or columns; use larger cells");
  }
  CheckMarks(lines);
  if (first == lines.size()) FailAt(0, 0, "the plan is empty; draw rooms with # and .");
  CheckEdges(lines, first, lines.size() - 1, columns);

  FloorPlan plan;
  plan.size = size;
  plan.stops = FindStops(lines, first);
  plan.lines.assign(lines.begin() + static_cast<std::ptrdiff_t>(first), lines.end());
  plan.columns = static_cast<int>(columns);
  plan.rows = static_cast<int>(plan.lines.size());
  bool any_floor = false;
  for (std::string& line : plan.lines) {
    line.resize(columns, '#');
    any_floor = any_floor || std::any_of(line.begin(), line.end(), IsOpenMark);
  }
  if (!any_floor) FailAt(first, 0, "no floor anywhere; draw rooms with .");
  return plan;
}

}  // namespace waystone
