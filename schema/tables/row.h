// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <SQLiteCpp/Column.h>
#include <SQLiteCpp/Statement.h>

#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "schema/tables/blob.h"
#include "schema/tables/table.h"

namespace waystone {

// One row of a table, read column after column in the descriptor's order, with validation: a value
// of another type or out of its range throws MapError(kMapDamaged) naming the column, the value and
// what was expected. Reading a column as another type than the descriptor's is a programmer's error
// (WS_CHECK). Blobs are views into the statement, valid until its next step. Not thread-safe.
class Row {
 public:
  // `statement` selects ColumnList(table).
  Row(SQLite::Statement& statement, const TableView& table)
      : statement_(statement), table_(table) {}

  // "planes 7", "plane_views 3/12".
  std::string Where() const;

  int64_t Int64(int64_t low, int64_t high = std::numeric_limits<int64_t>::max());
  int Int(int low = 0, int high = std::numeric_limits<int>::max());
  double Real();
  std::optional<double> OptionalReal();
  std::string Text();
  // A blob of exactly `bytes` bytes whose CRC-32C is as stored.
  BytesView Blob(int64_t bytes);
  // The same for any number of whole rows of `row_bytes` bytes.
  BytesView BlobOfRows(int row_bytes);
  bool IsNull() const { return statement_.getColumn(stored_).isNull(); }
  void SkipRest() { read_ = table_.columns.size(); }
  // WS_CHECK: that every column was read.
  void CheckComplete() const;

 private:
  // The next column of SQLite's.
  SQLite::Column Next(ColumnType type);
  void Advance(ColumnType type);
  BytesView CheckedBlob(const SQLite::Column& blob);

  SQLite::Statement& statement_;
  TableView table_;
  size_t read_ = 0;  // columns of the descriptor
  int stored_ = 0;   // columns of SQLite's
};

}  // namespace waystone
