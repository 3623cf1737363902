// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"

namespace waystone {

// A CSV file with a header: cells separated by commas, without quotes; empty lines and lines that
// start with '#' are skipped. White space around a cell is dropped. Immutable; thread-safe.
class CsvFile {
 public:
  struct Row {
    int line = 0;  // from 1
    std::vector<std::string> cells;
  };

  // Throws MapError: kFileUnreadable; kBadRequest for a file without a header, a header with two
  // columns of one name, or a line with more or fewer cells than it.
  explicit CsvFile(const std::filesystem::path& path);

  const std::filesystem::path& path() const { return path_; }
  const std::vector<Row>& rows() const { return rows_; }
  // The column with this name in the header; nothing where there is none.
  std::optional<size_t> Column(const std::string& name) const;
  // The number that is the whole of a cell. Fails for anything else.
  double Number(const Row& row, size_t column) const;

  // Throws MapError(kBadRequest): "queries.csv, line 7: CAUSE".
  [[noreturn]] void Fail(int line, const std::string& cause) const;

 private:
  void CheckHeader(int line) const;

  std::filesystem::path path_;
  std::vector<std::string> header_;
  std::vector<Row> rows_;
};

}  // namespace waystone
