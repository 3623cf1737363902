// SPDX-License-Identifier: Apache-2.0
#include "schema/tables/row.h"

#include <sqlite3.h>

#include <cmath>

#include "core/base/check.h"
#include "core/base/error.h"

namespace waystone {
namespace {

std::string TypeOf(const SQLite::Column& column) {
  switch (column.getType()) {
    case SQLITE_INTEGER:
      return "an integer";
    case SQLITE_FLOAT:
      return "a real number";
    case SQLITE_TEXT:
      return "text";
    case SQLITE_BLOB:
      return "a blob";
    default:
      return "NULL";
  }
}

[[noreturn]] void ThrowDamage(const SQLite::Column& column, const std::string& cause) {
  throw MapError(ErrorCode::kMapDamaged, std::string(column.getName()) + " " + cause);
}

void CheckType(const SQLite::Column& column, int type, const char* expected) {
  if (column.getType() == type) return;
  ThrowDamage(column, "is " + TypeOf(column) + " instead of " + expected);
}

}  // namespace

std::string Row::Where() const {
  std::string where(table_.name);
  for (int i = 0; i < table_.key_columns; ++i) {
    where += i == 0 ? ' ' : '/';
    where += std::to_string(statement_.getColumn(i).getInt64());
  }
  return where;
}

void Row::Advance(ColumnType type) {
  WS_CHECK(read_ < table_.columns.size(),
           std::string(table_.name) + " has no column " + std::to_string(read_));
  WS_CHECK(table_.columns[read_].type == type,
           std::string(table_.columns[read_].name) + " is read as another type");
  ++read_;
  stored_ += type == ColumnType::kBlob ? 2 : 1;
}

SQLite::Column Row::Next(ColumnType type) {
  Advance(type);
  return statement_.getColumn(stored_ - 1);
}

void Row::CheckComplete() const {
  WS_CHECK(read_ == table_.columns.size(),
           std::string(table_.name) + ": " + std::to_string(read_) + " columns were read");
}

int64_t Row::Int64(int64_t low, int64_t high) {
  const SQLite::Column column = Next(ColumnType::kInteger);
  CheckType(column, SQLITE_INTEGER, "an integer");
  const int64_t value = column.getInt64();
  if (value < low || value > high) {
    ThrowDamage(column, "is " + std::to_string(value) + "; " + std::to_string(low) + " to " +
                            std::to_string(high) + " are valid");
  }
  return value;
}

int Row::Int(int low, int high) { return static_cast<int>(Int64(low, high)); }

double Row::Real() {
  const SQLite::Column column = Next(ColumnType::kReal);
  CheckType(column, SQLITE_FLOAT, "a real number");
  const double value = column.getDouble();
  if (!std::isfinite(value)) ThrowDamage(column, "is not finite");
  return value;
}

std::optional<double> Row::OptionalReal() {
  if (!IsNull()) return Real();
  Advance(ColumnType::kReal);
  return {};
}

std::string Row::Text() {
  const SQLite::Column column = Next(ColumnType::kText);
  CheckType(column, SQLITE_TEXT, "text");
  return column.getString();
}

BytesView Row::Blob(int64_t bytes) {
  const SQLite::Column column = Next(ColumnType::kBlob);
  CheckType(column, SQLITE_BLOB, "a blob");
  if (column.getBytes() != bytes) {
    ThrowDamage(column, "has " + std::to_string(column.getBytes()) + " bytes; " +
                            std::to_string(bytes) + " expected");
  }
  return CheckedBlob(column);
}

BytesView Row::BlobOfRows(int row_bytes) {
  const SQLite::Column column = Next(ColumnType::kBlob);
  CheckType(column, SQLITE_BLOB, "a blob");
  if (column.getBytes() % row_bytes != 0) {
    ThrowDamage(column, "has " + std::to_string(column.getBytes()) + " bytes, not a multiple of " +
                            std::to_string(row_bytes));
  }
  return CheckedBlob(column);
}

BytesView Row::CheckedBlob(const SQLite::Column& column) {
  const SQLite::Column crc = statement_.getColumn(stored_ - 2);
  CheckType(crc, SQLITE_INTEGER, "an integer");
  // SQLite fetches a blob's pages here; nothing when it can't.
  const auto* data = static_cast<const uint8_t*>(column.getBlob());
  const BytesView blob(data, data == nullptr ? 0 : static_cast<size_t>(column.getBytes()));
  const uint32_t found = Crc32c(blob);
  if (found != crc.getInt64()) {
    ThrowDamage(column, "has CRC-32C " + HexOf(found) + "; " +
                            HexOf(static_cast<uint32_t>(crc.getInt64())) + " was written");
  }
  return blob;
}

}  // namespace waystone
