// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <SQLiteCpp/Statement.h>

#include <cstdint>
#include <optional>
#include <string>

#include "schema/tables/blob.h"

namespace waystone {

// A blob and the CRC in the column before it.
struct CheckedBlob {
  BytesView bytes;
};

// A prepared INSERT. Values are given in the order of the table's columns, or of the columns that
// stand in parentheses behind its name.
class Insert {
 public:
  Insert(SQLite::Database& database, const std::string& table, int columns)
      : statement_(database, "INSERT INTO " + table + " VALUES (?" + Repeated(columns - 1) + ")") {}

  template <class... Values>
  void Row(const Values&... values) {
    next_ = 1;
    (Bind(values), ...);
    statement_.exec();
    statement_.reset();
  }

 private:
  static std::string Repeated(int times) {
    std::string marks;
    for (int i = 0; i < times; ++i) marks += ", ?";
    return marks;
  }

  void Bind(int64_t value) { statement_.bind(next_++, value); }
  void Bind(int value) { statement_.bind(next_++, static_cast<int64_t>(value)); }
  void Bind(double value) { statement_.bind(next_++, value); }
  void Bind(const std::string& value) { statement_.bindNoCopy(next_++, value); }
  void Bind(std::nullptr_t) { statement_.bind(next_++); }
  void Bind(const std::optional<double>& value) { value ? Bind(*value) : Bind(nullptr); }
  void Bind(const CheckedBlob& blob) {
    statement_.bind(next_++, static_cast<int64_t>(Crc32c(blob.bytes)));
    // A null pointer would become NULL, even for no bytes.
    const void* data = blob.bytes.empty() ? "" : static_cast<const void*>(blob.bytes.data());
    statement_.bindNoCopy(next_++, data, static_cast<int>(blob.bytes.size()));
  }

  SQLite::Statement statement_;
  int next_ = 1;
};

}  // namespace waystone
