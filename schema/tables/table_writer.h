// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Statement.h>

#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>

#include "schema/tables/blob.h"
#include "schema/tables/table.h"

namespace waystone {

// Where the rows of a map go: into a database or, without one, only into a count of their bytes.
// Not thread-safe, as all classes here.
class RowSink {
 public:
  RowSink() = default;
  explicit RowSink(SQLite::Database& database) : database_(&database) {}

  SQLite::Database* database() const { return database_; }
  int64_t bytes() const { return bytes_; }  // of all values so far, without SQLite's own
  void AddBytes(int64_t bytes) { bytes_ += bytes; }

 private:
  SQLite::Database* database_ = nullptr;
  int64_t bytes_ = 0;
};

// A prepared INSERT into one table; without a database it only counts bytes. Throws
// SQLite::Exception. The sink must outlive it.
class RowInserter {
 public:
  RowInserter(RowSink& sink, const TableView& table);

  void Bind(std::nullptr_t, const Column& column);
  void Bind(int64_t value);
  void Bind(double value);
  void Bind(const std::string& value);  // must live until Finish()
  void Bind(BytesView blob);            // and its CRC; must live until Finish() too
  void Finish();                        // writes the row

 private:
  RowSink& sink_;
  std::optional<SQLite::Statement> statement_;
  int next_ = 1;
};

// Writes rows of one table: `TableWriter<kEdgesTable> edges(sink); edges.Row(edge.a, ...);`, one
// value per column of the descriptor. A wrong number of values, or a value of another type, doesn't
// compile. Enums and ids are stored as their numbers, a blob's CRC is computed.
template <const auto& kTable>
class TableWriter {
 public:
  explicit TableWriter(RowSink& sink) : inserter_(sink, kTable) {}

  template <class... Values>
  void Row(const Values&... values) {
    static_assert(sizeof...(Values) == kTable.columns.size(), "a value a column");
    static_assert(Fit<Values...>(), "a value has another type than its column");
    size_t i = 0;
    (Bind(values, kTable.columns[i++]), ...);
    inserter_.Finish();
  }

 private:
  template <class... Values>
  static constexpr bool Fit() {
    size_t i = 0;
    return (FitsColumn<std::decay_t<Values>>(kTable.columns[i++]) && ...);
  }

  template <class Value>
  void Bind(const Value& value, const Column& column) {
    if constexpr (std::is_same_v<Value, std::nullptr_t>) {
      inserter_.Bind(nullptr, column);
    } else if constexpr (std::is_same_v<Value, std::optional<double>>) {
      value ? inserter_.Bind(*value) : inserter_.Bind(nullptr, column);
    } else if constexpr (std::is_enum_v<Value> || std::is_integral_v<Value>) {
      inserter_.Bind(static_cast<int64_t>(value));
    } else if constexpr (table_internal::IsId<Value>::value) {
      inserter_.Bind(value.value);
    } else {
      inserter_.Bind(value);
    }
  }

  RowInserter inserter_;
};

}  // namespace waystone
