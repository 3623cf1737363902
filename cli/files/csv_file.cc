// SPDX-License-Identifier: Apache-2.0
#include "cli/files/csv_file.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <string_view>

#include "cli/files/map_file.h"
#include "core/base/text.h"

namespace waystone {
namespace {

std::vector<std::string> Cells(std::string_view line) {
  std::vector<std::string> cells;
  size_t start = 0;
  while (true) {
    const size_t comma = line.find(',', start);
    cells.emplace_back(Trimmed(line.substr(start, comma - start)));
    if (comma == std::string::npos) return cells;
    start = comma + 1;
  }
}

}  // namespace

CsvFile::CsvFile(const std::filesystem::path& path) : path_(path) {
  std::ifstream text = OpenText(path, "a CSV file");
  int number = 0;
  for (std::string line; std::getline(text, line);) {
    ++number;
    const std::string_view trimmed = Trimmed(line);
    if (trimmed.empty() || trimmed.front() == '#') continue;
    if (header_.empty()) {
      header_ = Cells(trimmed);
      CheckHeader(number);
      continue;
    }
    rows_.push_back({number, Cells(trimmed)});
    const size_t cells = rows_.back().cells.size();
    if (cells == header_.size()) continue;
    Fail(number, std::to_string(cells) + (cells == 1 ? " field" : " fields") +
                     ", but the header has " + std::to_string(header_.size()) +
                     "; write empty fields as consecutive commas");
  }
  if (header_.empty()) Fail(1, "missing header; the first line must name the columns");
}

void CsvFile::CheckHeader(int line) const {
  for (auto name = header_.begin(); name != header_.end(); ++name) {
    if (name->empty() || std::find(header_.begin(), name, *name) == name) continue;
    Fail(line, "the header has two columns \"" + *name + "\"; rename or remove one");
  }
}

std::optional<size_t> CsvFile::Column(const std::string& name) const {
  const auto found = std::find(header_.begin(), header_.end(), name);
  if (found == header_.end()) return std::nullopt;
  return static_cast<size_t>(found - header_.begin());
}

double CsvFile::Number(const Row& row, size_t column) const {
  const std::string& cell = row.cells.at(column);
  const std::optional<double> value = ToNumber(cell);
  if (value && std::isfinite(*value)) return *value;
  Fail(row.line, header_[column] + " is \"" + cell + "\"; it must be a number");
}

void CsvFile::Fail(int line, const std::string& cause) const {
  throw MapError(ErrorCode::kBadRequest,
                 path_.string() + ", line " + std::to_string(line) + ": " + cause);
}

}  // namespace waystone
