// SPDX-License-Identifier: Apache-2.0
// Descriptors of the tables of a map; all functions are pure; thread-safe. Each table's columns are
// listed once, in the order in which rows are written and read:
//
//   inline constexpr TableDescriptor kEdgesTable{
//       "edges", 2,
//       std::array{IntegerColumn("a"), IntegerColumn("b"), RealColumn("weight"),
//                  BlobColumn("homology")}};
//
// TableWriter checks the number and types of a row's values against them at compile time, Row when
// reading, and the tests check the migrations and FORMAT.md against them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "core/base/ids.h"
#include "schema/tables/blob.h"

namespace waystone {

enum class ColumnType { kInteger, kReal, kText, kBlob };

// A blob stands for two columns: its CRC-32C, "<name>_crc32c", and itself.
struct Column {
  std::string_view name;
  ColumnType type = ColumnType::kInteger;
  bool nullable = false;
};

constexpr Column IntegerColumn(std::string_view name) { return {name, ColumnType::kInteger}; }
constexpr Column RealColumn(std::string_view name) { return {name, ColumnType::kReal}; }
constexpr Column TextColumn(std::string_view name) { return {name, ColumnType::kText}; }
constexpr Column BlobColumn(std::string_view name) { return {name, ColumnType::kBlob}; }
constexpr Column OrNull(Column column) { return {column.name, column.type, true}; }

// A table: the first `key_columns` (1 or 2) columns are its primary key.
template <size_t n>
struct TableDescriptor {
  std::string_view name;
  int key_columns = 1;
  std::array<Column, n> columns;
};
template <size_t n>
TableDescriptor(std::string_view, int, std::array<Column, n>) -> TableDescriptor<n>;

// Any table's descriptor, where its number of columns doesn't matter. Views the descriptor.
struct TableView {
  std::string_view name;
  int key_columns = 1;
  std::span<const Column> columns;

  template <size_t n>
  constexpr TableView(const TableDescriptor<n>& table)  // NOLINT(google-explicit-constructor)
      : name(table.name), key_columns(table.key_columns), columns(table.columns) {}
};

// "a, b, weight, homology_crc32c, homology".
std::string ColumnList(const TableView& table);
// The number of the table's columns in SQLite, including CRCs: 5 in the example above.
int StoredColumns(const TableView& table);

namespace table_internal {

template <class Value>
struct IsId : std::false_type {};
template <class Tag>
struct IsId<Id<Tag>> : std::true_type {};

}  // namespace table_internal

// Whether a value of that type may be written to the column.
template <class Value>
constexpr bool FitsColumn(const Column& column) {
  if constexpr (std::is_same_v<Value, std::nullptr_t>) {
    return column.nullable;
  } else if constexpr (std::is_same_v<Value, std::optional<double>>) {
    return column.nullable && column.type == ColumnType::kReal;
  } else if constexpr (std::is_floating_point_v<Value>) {
    return column.type == ColumnType::kReal;
  } else if constexpr (std::is_same_v<Value, std::string>) {
    return column.type == ColumnType::kText;
  } else if constexpr (std::is_convertible_v<const Value&, BytesView>) {
    return column.type == ColumnType::kBlob;
  } else {
    static_assert(std::is_integral_v<Value> || std::is_enum_v<Value> ||
                  table_internal::IsId<Value>::value);
    return column.type == ColumnType::kInteger;
  }
}

}  // namespace waystone
