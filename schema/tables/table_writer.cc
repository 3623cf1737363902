// SPDX-License-Identifier: Apache-2.0
#include "schema/tables/table_writer.h"

namespace waystone {
namespace {

constexpr int64_t kNumberBytes = 8;

std::string InsertStatement(const TableView& table) {
  std::string marks = "?";
  for (int i = 1; i < StoredColumns(table); ++i) marks += ", ?";
  return "INSERT INTO " + std::string(table.name) + " (" + ColumnList(table) + ") VALUES (" +
         marks + ")";
}

}  // namespace

RowInserter::RowInserter(RowSink& sink, const TableView& table) : sink_(sink) {
  if (sink.database() != nullptr) statement_.emplace(*sink.database(), InsertStatement(table));
}

void RowInserter::Bind(std::nullptr_t, const Column& column) {
  const int stored = column.type == ColumnType::kBlob ? 2 : 1;
  for (int i = 0; statement_ && i < stored; ++i) statement_->bind(next_++);
}

void RowInserter::Bind(int64_t value) {
  sink_.AddBytes(kNumberBytes);
  if (statement_) statement_->bind(next_++, value);
}

void RowInserter::Bind(double value) {
  sink_.AddBytes(kNumberBytes);
  if (statement_) statement_->bind(next_++, value);
}

void RowInserter::Bind(const std::string& value) {
  sink_.AddBytes(std::ssize(value));
  if (statement_) statement_->bindNoCopy(next_++, value);
}

void RowInserter::Bind(BytesView blob) {
  sink_.AddBytes(kNumberBytes + std::ssize(blob));
  if (!statement_) return;
  statement_->bind(next_++, static_cast<int64_t>(Crc32c(blob)));
  // A null pointer would become NULL, even for no bytes.
  const void* data = blob.empty() ? "" : static_cast<const void*>(blob.data());
  statement_->bindNoCopy(next_++, data, static_cast<int>(blob.size()));
}

void RowInserter::Finish() {
  if (statement_) {
    statement_->exec();
    statement_->reset();
  }
  next_ = 1;
}

}  // namespace waystone
