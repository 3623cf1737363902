// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <SQLiteCpp/Column.h>
#include <SQLiteCpp/Statement.h>

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "schema/tables/blob.h"

namespace waystone {

// One row of a result, read column after column and without trust: a value of another type or out
// of its range throws MapError(kMapDamaged) naming the column, the value and what was expected.
// Views into the statement: what it gives is valid until the statement's next step.
class Row {
 public:
  // The first `key_columns` columns name the row.
  Row(SQLite::Statement& statement, std::string_view table, int key_columns)
      : statement_(statement), table_(table), key_columns_(key_columns) {}

  // "planes 7", "plane_views 3/12".
  std::string Where() const;

  int64_t Int64(int64_t low, int64_t high = std::numeric_limits<int64_t>::max());
  int Int(int low = 0, int high = std::numeric_limits<int>::max());
  double Real();
  std::optional<double> OptionalReal();
  std::string Text();
  // A blob with its CRC-32C in the column before it, for exactly `bytes` bytes.
  BytesView Blob(int64_t bytes);
  // The same for any number of whole rows of `row_bytes` bytes.
  BytesView BlobOfRows(int row_bytes);
  bool IsNull() const { return statement_.getColumn(next_).isNull(); }
  void Skip(int columns) { next_ += columns; }

 private:
  SQLite::Column Next() { return statement_.getColumn(next_++); }
  BytesView CheckedBlob();

  SQLite::Statement& statement_;
  std::string_view table_;
  int key_columns_;
  int next_ = 0;
};

}  // namespace waystone
